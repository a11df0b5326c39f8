"""Whether stamps tell a rate at all."""

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND

LEAST_COVERED_NS = NANOSECONDS_PER_SECOND // 50
"""Time that regular steps must cover before they tell a rate: 20 steps at 1 kHz, one at 50 Hz."""


def tells_rate(stamp_ns: NDArray[np.int64], period_ns: float) -> bool:
    """Tell whether enough steps of about one period are there.

    Parameters
    ----------
    stamp_ns : (n_samples,) int64 array [ns]
        In order.
    period_ns : float [ns]
        The step that was found.
    """
    steps = np.diff(stamp_ns)
    regular = steps[(steps > 0.5 * period_ns) & (steps < 1.51 * period_ns)]
    return bool(regular.sum() >= LEAST_COVERED_NS)
