"""Whether the controller sends as often as it is believed to.

A plan moves on by one ``cycle_s`` per packet: with another period its references and their speeds
would contradict each other.
"""

from modal_core.errors import BridgeError
from robot_bridge.egm import RobotFeedback

UINT32 = 1 << 32
ENOUGH_PACKETS, MOST_PACKETS = 50, 500
# 4.000 ms of virtual and 4.032 ms of real controllers are 0.8 % apart: both are "4 ms".
LARGEST_DEVIATION = 0.02
# The clock tells whole milliseconds, so both ends of a stretch are off by up to half of one.
CLOCK_S = 1e-3


class PaceCheck:
    """Measures the period of a session by the controller's own clock, whole milliseconds.

    Parameters
    ----------
    cycle_s : float [s]
        Period expected.
    """

    def __init__(self, cycle_s: float) -> None:
        self._cycle_s = cycle_s
        self._first: RobotFeedback | None = None
        self._passed_s = 0.0
        self._n_cycles = 0

    def add(self, feedback: RobotFeedback, *, begins: bool) -> None:
        """Take an accepted packet; ``begins`` says that it is the first of a session."""
        first = self._first
        if first is None or begins:
            self._first, self._n_cycles = feedback, 0
            return
        n_cycles = (feedback.seqno - first.seqno) % UINT32
        if n_cycles >= ENOUGH_PACKETS:
            self._n_cycles = n_cycles
            self._passed_s = 1e-3 * ((feedback.tm_ms - first.tm_ms) % UINT32)
        if n_cycles >= MOST_PACKETS:
            self._first = feedback

    def check(self) -> None:
        """Refuse another period; one that is not known yet, or a clock that stands, is let pass.

        Raises
        ------
        BridgeError
            The period differs by more than a fiftieth and the clock's resolution.
        """
        if self._n_cycles == 0 or self._passed_s == 0.0:
            return
        expected_s = self._n_cycles * self._cycle_s
        if abs(self._passed_s - expected_s) > LARGEST_DEVIATION * expected_s + CLOCK_S:
            raise BridgeError(
                'the controller sends at another period',
                where='cycle_s',
                found=f'{1e3 * self._passed_s / self._n_cycles:.3f} ms',
                expected=f'{1e3 * self._cycle_s:.3f} ms +- {100.0 * LARGEST_DEVIATION:g} %',
                advice='set cycle_s to SampleRate: 0.004032 for 4 ms',
            )
