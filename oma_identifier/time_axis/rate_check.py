"""What rate stamps tell, if any."""

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from oma_identifier.time_axis.coarse_stamps import is_coarse

LEAST_COVERED_NS = NANOSECONDS_PER_SECOND // 50
"""Time that regular steps must cover before they tell a rate: 20 steps at 1 kHz, one at 50 Hz."""
FEWEST_SHORT, LEAST_SHORT = 8, 0.2
"""Steps shorter than the median that are taken for the period: at a random loss of 70 % there are
30 % of them."""
ALIKE, MOSTLY = 0.1, 0.6
"""How nearly, and how many of them must be of one length: jitter makes no such pile."""


def tells_rate(stamp_ns: NDArray[np.int64], period_ns: float) -> bool:
    """Tell whether enough steps of about one period are there.

    Parameters
    ----------
    stamp_ns : (n_samples,) int64 array [ns]
        In order.
    period_ns : float [ns]
        The step that was found.
    """
    if is_coarse(stamp_ns):
        return bool(stamp_ns[-1] - stamp_ns[0] >= LEAST_COVERED_NS)
    steps = np.diff(stamp_ns)
    regular = steps[(steps > 0.5 * period_ns) & (steps < 1.51 * period_ns)]
    return bool(regular.sum() >= LEAST_COVERED_NS)


def typical_step(steps: NDArray[np.int64]) -> float:
    """Return about one period, also where half of the samples or more are lost [ns].

    The median, unless a good part of the steps are one whole fraction of it: then the median
    spans lost samples.

    Parameters
    ----------
    steps : (n_steps,) int64 array [ns]
        Between neighbours.
    """
    typical = float(np.partition(steps, (len(steps) - 1) // 2)[(len(steps) - 1) // 2])
    while True:
        short = steps[(steps > 0.1 * typical) & (steps < 0.75 * typical)]
        if len(short) < FEWEST_SHORT or len(short) < LEAST_SHORT * len(steps):
            return typical
        shorter = float(np.median(short))
        ratio = typical / shorter
        alike = np.abs(short / shorter - 1.0) < ALIKE
        if abs(ratio - round(ratio)) > ALIKE * ratio or alike.mean() < MOSTLY:
            return typical
        typical = shorter
