"""Whether the structure was at rest when the trigger of a recording's tap came.

What taps in a recording leave for the next is known with the poles; what was struck before it
began is not, and looks like noise that is strongest where the modes are.
"""

import numpy as np
from numpy.typing import NDArray

from impact_testing.responses.spectra import PointSpectra
from impact_testing.taps import BEHIND_S

Real = NDArray[np.float64]
FEWEST_ROWS = 6
"""Before a tap.  With 16, 40 modes of the 40 tests below kept standard deviations, and two of them
held 35 frequencies; with 6, 18 and 17."""
SURE = 4.0
"""Deviations that noise does not reach."""
AT_REST = 0.005
"""Share of the response to a tap that moves before it.  Of 40 tests whose structures rang more
(984400 to 984439) two deviations held 66 of 74 frequencies, and 51 masses; of 30 that rested
(984500 to 984529) none was called moving."""
SECOND_DIFFERENCE = 6.0
"""Power of white noise in differences of differences, over its own."""


def at_rest_before(spectra: PointSpectra) -> bool:
    """Tell whether structures rest when the runs of a record begin, in most of them.

    Of a record of one run, or too few rows before the taps, nothing else is said.
    """
    record, shares = spectra.record, list[float]()
    if len(record.runs) == 1:
        return True
    for run in record.runs:
        inside = [p.first for p in spectra.pulses if run.first <= p.first < run.end]
        if inside and inside[0] - run.first >= FEWEST_ROWS:
            behind = slice(inside[0], inside[0] + round(BEHIND_S * record.rate_hz))
            before = record.responses.widened(slice(run.first, inside[0]))
            loud = record.responses.widened(behind)
            shares.append(float(np.max(_motion(before) / np.maximum(_motion(loud), 1e-300))))
    return not shares or float(np.median(shares)) < AT_REST


def _motion(rows: Real) -> Real:
    """Return the root mean square of what is no white noise, by channel."""
    noise = np.mean(np.diff(rows, 2, axis=0) ** 2, axis=0) / SECOND_DIFFERENCE
    # Of n values the variance scatters by √(2 / n).
    most = noise * (1.0 + SURE * np.sqrt(2.0 / len(rows)))
    return np.asarray(np.sqrt(np.maximum(rows.var(axis=0) - most, 0.0)))
