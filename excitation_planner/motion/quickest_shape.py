"""The move a controller makes of its limits, and the limits behind a planned move.

A controller of the MoveAbsJ kind goes from rest to rest as quickly as speed, acceleration and
build-up of acceleration (jerk) allow.  Both directions are needed: which move some limits make,
and which limits make a planned move.

References
----------
Biagiotti and Melchiorri (2008), Trajectory Planning for Automatic Machines and Robots, section
3.4, doi:10.1007/978-3-540-85629-0.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from excitation_planner.motion.pulse_shape import PulseShape

Array = NDArray[np.float64]
SHORTEST_S = 1e-6
# AccSet: a controller raises anything below these parts of its acceleration and of its build-up.
LEAST_ACCELERATION, LEAST_JERK = 0.2, 0.1


def quickest_shape(speed: float, acceleration: float, jerk: float) -> PulseShape:
    """Return the quickest move of unit length under limits [1/s], [1/s²], [1/s³]."""
    if speed * jerk >= acceleration**2:
        ramp_s = acceleration / jerk
        rise_s = ramp_s + speed / acceleration
    else:
        ramp_s = math.sqrt(speed / jerk)
        rise_s = 2.0 * ramp_s
    if rise_s * speed <= 1.0:
        return PulseShape(rise_s + 1.0 / speed, rise_s, ramp_s)
    # Full speed is never reached: the way is gone while speeding up and slowing down.
    ramp_s = acceleration / jerk
    if 2.0 * acceleration * ramp_s**2 <= 1.0:
        rise_s = ramp_s / 2.0 + math.sqrt(ramp_s**2 / 4.0 + 1.0 / acceleration)
    else:
        ramp_s = (0.5 / jerk) ** (1.0 / 3.0)
        rise_s = 2.0 * ramp_s
    return PulseShape(2.0 * rise_s, rise_s, ramp_s)


def fitted_shape(velocity: Array, period_s: float) -> tuple[PulseShape, float]:
    """Return the shape behind the sampled velocity of a unit move, and how far it is off.

    Parameters
    ----------
    velocity : (n,) array [1/s]
        From the last sample at rest to the first one at rest again.
    period_s : float [s]
        Between samples.

    Returns
    -------
    shape : PulseShape
        Of least squares; its three times are those of three boxes whose convolution it is.
    misfit : float
        Largest difference over the peak.
    """
    time_s = np.asarray(np.arange(len(velocity)) * period_s)
    peak = float(np.max(velocity))
    delay_s = 1.0 / peak
    rise_s = max(time_s[-1] - delay_s, 2.0 * period_s)
    plateau_s = min(max(peak * period_s / np.max(np.diff(velocity)), 0.5 * rise_s), rise_s)
    first = np.array([max(rise_s - plateau_s, 0.2 * rise_s), plateau_s, delay_s])

    def misfit(times_s: Array) -> Array:
        return (_of_boxes(times_s).velocity(time_s) - velocity) / peak

    found = least_squares(
        misfit, first, x_scale=first, bounds=(SHORTEST_S, np.inf), xtol=1e-12, ftol=1e-12
    )
    return _of_boxes(found.x), float(np.max(np.abs(found.fun)))


def _of_boxes(times_s: Array) -> PulseShape:
    # A convolution does not tell the two boxes apart; a build-up is no longer than its plateau.
    ramp_s, rise_s = float(np.min(times_s[:2])), float(np.sum(times_s[:2]))
    return PulseShape(rise_s + float(times_s[2]), rise_s, ramp_s)
