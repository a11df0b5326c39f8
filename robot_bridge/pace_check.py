"""Whether the controller sends as often as it is believed to.

A plan moves on by one ``cycle_s`` per packet: with another period its references and their speeds
would contradict each other.
"""

from modal_core.errors import BridgeError
from robot_bridge.egm_feedback import RobotFeedback

UINT32 = 1 << 32
ENOUGH_PACKETS = 50
LARGEST_RATIO = 1.2


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
        self._measured_s = 0.0

    def add(self, feedback: RobotFeedback, *, begins: bool) -> None:
        """Take an accepted packet; ``begins`` says that it is the first of a session."""
        first = self._first
        if first is None or begins:
            self._first, self._measured_s = feedback, 0.0
            return
        n_cycles = (feedback.seqno - first.seqno) % UINT32
        if n_cycles >= ENOUGH_PACKETS:
            passed_ms = (feedback.tm_ms - first.tm_ms) % UINT32
            self._first, self._measured_s = feedback, 1e-3 * passed_ms / n_cycles

    def check(self) -> None:
        """Refuse another period; one that is not known yet, or a clock that stands, is let pass.

        Raises
        ------
        BridgeError
            The period differs by more than a fifth.
        """
        found, expected = self._measured_s, self._cycle_s
        if found > 0.0 and not expected / LARGEST_RATIO < found < expected * LARGEST_RATIO:
            raise BridgeError(
                'the controller sends at another period',
                where='cycle_s',
                found=f'{1e3 * found:.3f} ms',
                expected=f'{1e3 * expected:.3f} ms',
                advice='set cycle_s to SampleRate: 0.004032 for 4 ms',
            )
