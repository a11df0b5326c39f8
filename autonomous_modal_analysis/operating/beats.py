"""When a beat is due, and how punctual the beats were; no ROS."""

from dataclasses import dataclass
import math

PERIOD_S = 0.02
LATE_S = 0.1
"""A beat is late when the last is older: the bridge asks for 10 Hz, and stops after 0.13 s."""


@dataclass(frozen=True, slots=True)
class BeatReport:
    """How the beats went.

    Parameters
    ----------
    n_beats, n_late : int
        Beats, and those of them that came late.
    longest_s : float [s]
        Longest time between two of one hold.
    n_listeners : int
        Who hears them.
    """

    n_beats: int = 0
    n_late: int = 0
    longest_s: float = 0.0
    n_listeners: int = 0

    def line(self) -> str:
        """Return the report as one line."""
        return f'{self.n_beats} {self.n_late} {self.longest_s:.4f} {self.n_listeners}'

    @classmethod
    def from_line(cls, line: str) -> 'BeatReport':
        """Return the report of a line."""
        n_beats, n_late, longest_s, n_listeners = line.split()
        return cls(int(n_beats), int(n_late), float(longest_s), int(n_listeners))


class Beats:
    """Beats of one holder after the other."""

    def __init__(self) -> None:
        self._text = self._token = ''
        self._until_s = self._last_s = -math.inf
        self._n_beats = self._n_late = 0
        self._longest_s = 0.0

    def hear(self, text: str) -> None:
        """Take lines ``TOKEN UNTIL``; the last whole one counts."""
        *lines, self._text = (self._text + text).split('\n')
        for line in lines:
            token, until_s = line.split()
            if token != self._token:
                self._token, self._last_s = token, -math.inf
                self._n_beats = self._n_late = 0
                self._longest_s = 0.0
            self._until_s = float(until_s)

    def due(self, now_s: float) -> str:
        """Return the token of the beat that is due now [s]; empty for none."""
        if now_s > self._until_s:
            self._last_s = -math.inf  # the next hold of this token begins anew
            return ''
        if self._last_s > -math.inf:
            gap_s = now_s - self._last_s
            self._n_late += gap_s > LATE_S
            self._longest_s = max(self._longest_s, gap_s)
        self._n_beats, self._last_s = self._n_beats + 1, now_s
        return self._token

    def report(self, n_listeners: int) -> BeatReport:
        """Return how the beats of this holder went."""
        return BeatReport(self._n_beats, self._n_late, self._longest_s, n_listeners)
