"""The speed of a spindle over time, as it was measured beside the responses."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND

MOST_VALUES = 100_000
"""Kept of a record: of a longer one every other value goes, as often as needed."""
LONGEST_GAP_S = 2.0
"""Between values, and at the ends of a stretch: a spindle changes its speed within a second or
so; beyond, its course is not known."""


@dataclass(frozen=True, slots=True)
class SpindleSpeed:
    """Values in the order of their times.

    Parameters
    ----------
    stamp_ns : (n_values,) int64 array [ns]
        On the clock of the responses, to a tenth of a second or so.
    speed_hz : (n_values,) array [Hz]
        Turns per second.
    """

    stamp_ns: NDArray[np.int64]
    speed_hz: NDArray[np.float64]

    @classmethod
    def of(cls, stamp_ns: NDArray[np.int64], speed_hz: NDArray[np.float64]) -> 'SpindleSpeed':
        """Return values in order, without those that are no numbers."""
        finite = np.isfinite(speed_hz)
        stamps, first = np.unique(stamp_ns[finite], return_index=True)
        return cls(stamps, speed_hz[finite][first])

    def joined(self, newer: 'SpindleSpeed') -> 'SpindleSpeed':
        """Return both, in bounded memory."""
        both = SpindleSpeed.of(
            np.concatenate([self.stamp_ns, newer.stamp_ns]),
            np.concatenate([self.speed_hz, newer.speed_hz]),
        )
        while len(both.stamp_ns) > MOST_VALUES:
            both = SpindleSpeed(both.stamp_ns[::2], both.speed_hz[::2])
        return both

    def between(self, start_ns: int, end_ns: int) -> 'SpindleSpeed':
        """Return the values of a stretch, and of as long beside it as may be bridged."""
        gap_ns = round(LONGEST_GAP_S * NANOSECONDS_PER_SECOND)
        first, last = np.searchsorted(self.stamp_ns, (start_ns - gap_ns, end_ns + gap_ns))
        return SpindleSpeed(self.stamp_ns[first:last], self.speed_hz[first:last])

    def at(self, start_ns: int, rate_hz: float, n_samples: int) -> NDArray[np.float64] | None:
        """Return the speed at every sample of a stretch [Hz].

        Parameters
        ----------
        start_ns : int [ns]
            First sample.
        rate_hz : float [Hz]
            Of the samples.
        n_samples : int
            How many.

        Returns
        -------
        (n_samples,) array or None
            None where values are missing for long, or the spindle stands.
        """
        wanted_s = np.arange(n_samples) / rate_hz
        known_s = (self.stamp_ns - start_ns) / NANOSECONDS_PER_SECOND
        inside = known_s[(known_s > 0.0) & (known_s < wanted_s[-1])]
        steps = np.diff(np.concatenate([[0.0], inside, wanted_s[-1:]]))
        if len(known_s) == 0 or steps.max() > LONGEST_GAP_S:
            return None
        speed_hz = np.interp(wanted_s, known_s, self.speed_hz)
        return speed_hz if speed_hz.min() > 0.0 else None
