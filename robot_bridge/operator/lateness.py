"""How late replies may have reached the controller in this session: packets come in bursts then.

A burst means that one of both stood still: the controller ran on without replies meanwhile, or
they are queued in it now, for good, since it reads one in a cycle.
"""

import math

MEMORY_S = 1.0
PUNCTUAL_S = 0.02


class Lateness:
    """The longest burst of a session.

    Parameters
    ----------
    cycle_s : float [s]
        Period of the controller.
    longest_s : float [s]
        Later replies are not given.

    Attributes
    ----------
    worst_s : float [s]
        Of the session so far.
    n_calm : int
        Cycles since the last burst.
    """

    def __init__(self, cycle_s: float, longest_s: float) -> None:
        self.worst_s, self.n_calm = 0.0, 0
        self.longest_s = longest_s
        self._cycle_s = cycle_s
        self._controller_s, self._peak_s = 0.0, -math.inf

    def add(self, n_steps: int, now_s: float, *, begins: bool) -> None:
        """Take a packet, the cycles since the one before, and the host time [s]."""
        if begins:
            self.worst_s, self.n_calm, self._peak_s = 0.0, 0, -math.inf
        step_s = n_steps * self._cycle_s
        self._controller_s += step_s
        ahead_s = now_s - self._controller_s
        # The peak fades, so that a cycle a little shorter than believed is no lateness.
        self._peak_s = max(ahead_s, self._peak_s)
        behind_s = self._peak_s - ahead_s
        self._peak_s -= behind_s * min(step_s / MEMORY_S, 1.0)
        late_s = max(behind_s, (n_steps - 1) * self._cycle_s)
        self.worst_s = min(max(self.worst_s, late_s), self.longest_s)
        self.n_calm = 0 if late_s > PUNCTUAL_S else self.n_calm + n_steps
