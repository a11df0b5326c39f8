"""Peaks of the measured FRFs that the modes do not explain.

Of 40 random healthy structures (0.5 to 5 %) none had such a peak; of twenty with 0.05 to 0.3 %,
struck again while they rang, three had a strong mode missing or wrong: all three were told.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit import left_by
from impact_testing.responses import PointData

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
SHARE = 0.5
"""Of a peak's power that modes leave, amplitudes free: of a mode that is there they leave little,
of one that is not nearly all."""
BEYOND_NOISE = 4.0
"""Mean square of what is left over the noise: noise itself reaches half of it."""
PROMINENT = 4.0
"""Power of a peak over the median of its neighbourhood."""
BESIDE = 16
"""Lines on either side that are its neighbourhood."""
STRONG = 1e-3
"""Of the power of the strongest line, each channel over its noise: weaker peaks are told by
nobody's eye."""


def unexplained_peaks(data: Sequence[PointData], pole: Complex) -> tuple[float, ...]:
    """Return the frequencies of strong peaks that none of the modes explains [Hz].

    Parameters
    ----------
    data : sequence of PointData
    pole : (n_poles,) complex array [rad/s]
        Of the modes that are reported.
    """
    frequency_hz = data[0].frequency_hz
    measured, left = np.zeros(len(frequency_hz)), np.zeros(len(frequency_hz))
    noise = np.zeros(len(frequency_hz))
    for each in data:
        scaled = each.frf.h1[each.lines] / np.sqrt(each.level)
        measured += np.sum(np.abs(scaled) ** 2, axis=1)
        left += np.sum(np.abs(left_by(each, pole)) ** 2, axis=1)
        # Real and imaginary parts have the course each.
        noise += 2.0 * len(each.level) * each.course
    usual = np.array(
        [np.median(measured[max(0, n - BESIDE) : n + BESIDE + 1]) for n in range(len(measured))]
    )
    strange = (left > SHARE * measured) & (left > BEYOND_NOISE * noise)
    strange &= (measured > PROMINENT * usual) & (measured > STRONG * measured.max())
    at = np.flatnonzero(strange)
    groups = np.split(at, np.flatnonzero(np.diff(at) > 2) + 1) if at.size else []
    tops = [int(group[np.argmax(left[group])]) for group in groups]
    return tuple(frequency_hz[tops].tolist())
