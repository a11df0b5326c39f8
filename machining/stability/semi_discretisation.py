"""Limiting depth by semi-discretisation: where a vibration neither grows nor falls.

The force varies with the turn as it does; so also what the mean force cannot show, chatter that
doubles the period (flip), comes out, and of several modes how they act on one another.
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from machining.cut import Cut
from machining.stability.period_map import spectral_radius
from machining.stability.zeroth_order import Limits
from modal_core.tool_modes import ToolModes

Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DepthSearch:
    """How the first depth that chatters is looked for.

    Parameters
    ----------
    shallowest_m, deepest_m : float [m]
        Depths between which it is looked for.
    ratio : float
        From one depth looked at to the next, from below; an island of chatter narrower than that
        may be missed.
    precision : float
        Relative, of the limit.
    """

    shallowest_m: float
    deepest_m: float
    ratio: float = 1.15
    precision: float = 5e-4


def limits_of_periods(
    modes: ToolModes, cut: Cut, speed_rpm: Real, search: DepthSearch, finer: float = 1.0
) -> Limits:
    """Return the limits by semi-discretisation; the chatter frequencies are not told.

    Parameters
    ----------
    modes : ToolModes
        In the axes of the cut.
    cut : Cut
    speed_rpm : (n,) array [rpm]
    search : DepthSearch
    finer : float
        Factor on the number of steps per period.
    """
    speeds = np.atleast_1d(np.asarray(speed_rpm, float))
    depth = np.array([_first_limit(modes, cut, float(each), search, finer) for each in speeds])
    return Limits(speeds, depth, np.full(len(speeds), math.nan))


def _first_limit(
    modes: ToolModes, cut: Cut, speed_rpm: float, search: DepthSearch, finer: float
) -> float:
    """Return the depth at which growth first begins; inf where nowhere."""

    def growth(depth_m: float) -> float:
        return math.log(spectral_radius(modes, cut, speed_rpm, depth_m, finer))

    low = search.shallowest_m
    if growth(low) >= 0.0:
        return low
    while low < search.deepest_m:
        high = min(low * search.ratio, search.deepest_m)
        if growth(high) >= 0.0:
            ends = math.log(low), math.log(high)
            return math.exp(
                brentq(lambda log: growth(math.exp(log)), *ends, xtol=search.precision)
            )
        low = high
    return math.inf
