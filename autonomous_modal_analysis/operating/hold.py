"""Whether a person holds something down, told from signs that come again and again.

A terminal tells no key-up: a key that is held repeats itself, after a first delay, until it is let
go.  So a hold begins only when the key repeats, which a single stroke never does, and it is over
``GAP_S`` after the last sign.  What is over stays over: the next motion needs a new release.
"""

import math

GAP_S = 0.3
"""No sign for so long is a release.  Keys repeat 10 to 40 times a second, buttons of
``joy_node`` 20 times; with the bridge's time-out (0.13 s) and stop ramp (0.05 s) a real arm
stands within the half second that the bridge allows."""
FIRST_GAP_S = 1.2
"""From a stroke to its first repeat: 0.2 to 1 s on common systems."""
SHORTEST_S = 0.25
"""Signs must have come for so long before a hold begins: text that is pasted does not."""
KEY_SIGNS, BUTTON_SIGNS = 4, 2
"""Signs that begin a hold."""


class Hold:
    """One hold, from its first sign to its end.

    Parameters
    ----------
    n_signs : int
        Signs that begin it.
    first_gap_s : float [s]
        Longest gap between the first two.

    Attributes
    ----------
    begun, over : bool
        It is or was held; it is no longer, for good.
    """

    def __init__(self, n_signs: int = KEY_SIGNS, first_gap_s: float = FIRST_GAP_S) -> None:
        self.begun = self.over = False
        self._n_signs, self._first_gap_s = n_signs, first_gap_s
        self._n, self._first_s, self._last_s = 0, -math.inf, -math.inf

    @property
    def until_s(self) -> float:
        """Until when it counts as held [s]."""
        return self._last_s + GAP_S if self.begun and not self.over else -math.inf

    def sign(self, at_s: float) -> None:
        """Take a sign that came at this time [s], or later."""
        self.look(at_s)
        if self.over:
            return
        longest_s = self._first_gap_s if self._n == 1 else GAP_S
        if self._n == 0 or at_s - self._last_s > longest_s:
            self._n, self._first_s = 0, at_s
        self._n, self._last_s = self._n + 1, at_s
        lasts = at_s - self._first_s >= SHORTEST_S
        self.begun = self.begun or (lasts and self._n >= self._n_signs)

    def look(self, now_s: float) -> None:
        """Let time pass."""
        if self.begun and now_s > self._last_s + GAP_S:
            self.over = True

    def let_go(self) -> None:
        """End it at once; a hold that has not begun begins anew."""
        self.over = self.begun
        self._n = 0
