"""What rate stamps tell, if any."""

import numpy as np
from numpy.typing import NDArray

from oma_identifier.time_axis.coarse_stamps import is_coarse
from oma_identifier.time_axis.thresholds import TIME_AXIS


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
        return bool(stamp_ns[-1] - stamp_ns[0] >= TIME_AXIS.least_covered_ns)
    steps = np.diff(stamp_ns)
    regular = steps[(steps > 0.5 * period_ns) & (steps < 1.51 * period_ns)]
    return bool(regular.sum() >= TIME_AXIS.least_covered_ns)


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
        if len(short) < TIME_AXIS.fewest_short or len(short) < TIME_AXIS.least_short * len(steps):
            return typical
        shorter = float(np.median(short))
        ratio = typical / shorter
        alike = np.abs(short / shorter - 1.0) < TIME_AXIS.step_alike
        if (
            abs(ratio - round(ratio)) > TIME_AXIS.step_alike * ratio
            or alike.mean() < TIME_AXIS.mostly_alike
        ):
            return typical
        typical = shorter
