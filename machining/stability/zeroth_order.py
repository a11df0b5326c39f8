"""Limiting depth by the mean of the cutting force over a turn: the zeroth-order solution.

With the receptance G and the mean directional matrix D the cut is at its limit at the depth a
where a (1 − exp(−jωT)) λ = 1 for an eigenvalue λ of G D, T from tooth to tooth.  So a locus
λ (1 − exp(−jωT)) over frequency is looked at where it crosses the positive real axis; the
furthest crossing is the limit.  That is the condition of Altintas and Budak, whose a follows as
1 / (2 Re λ), without lobes to be counted; cross terms and the axial direction stand in G and D.

References
----------
Altintas and Budak (1995), doi:10.1016/S0007-8506(07)62342-7, equations 14 to 20.
"""

from dataclasses import dataclass
from itertools import permutations
import math

import numpy as np
from numpy.typing import NDArray

from machining.cut import Cut
from modal_core.tool_modes import ToolModes

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
TURN_STEP_RAD = 0.03
"""Of ωT between lines: straight lines between them miss the locus by an eighth of its square."""
PER_BANDWIDTH = 12.0
"""Lines per half-power bandwidth of a mode, near it."""
ABOVE = 2.5
"""Lines reach this far above the highest mode; further up only mass is left."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Limiting depth over spindle speed.

    Parameters
    ----------
    speed_rpm : (n,) array
    depth_m : (n,) array [m]
        At and above which the cut chatters; inf where it never does.
    chatter_hz : (n,) array [Hz]
        Of the vibration that begins there; NaN where none does, or where it is not told.
    """

    speed_rpm: Real
    depth_m: Real
    chatter_hz: Real


def limits_of_modes(modes: ToolModes, cut: Cut, speed_rpm: Real) -> Limits:
    """Return the zeroth-order limits of a tool known by its modes.

    Parameters
    ----------
    modes : ToolModes
        In the axes of the cut: x along the feed, z along the cutter.
    cut : Cut
    speed_rpm : (n,) array [rpm]
        Spindle speeds.
    """
    lines = _lines(modes, cut.cutter.tooth_period_s(float(np.min(speed_rpm))))
    return _limits(lines, _loci(modes.receptance(lines), cut), cut, speed_rpm)


def limits_of_response(
    frequency_hz: Real, receptance: Complex, cut: Cut, speed_rpm: Real
) -> Limits:
    """Return the zeroth-order limits of a tool known by its measured response.

    Parameters
    ----------
    frequency_hz : (n_lines,) array [Hz]
        Rising; nothing outside them is looked at.
    receptance : (n_lines, 3, 3) array [m/N]
        In the axes of the cut.
    cut : Cut
    speed_rpm : (n,) array [rpm]
        Spindle speeds.
    """
    loci = _loci(receptance, cut)
    slowest_s = cut.cutter.tooth_period_s(float(np.min(speed_rpm)))
    step_hz = TURN_STEP_RAD / (2.0 * math.pi * slowest_s)
    between = np.arange(frequency_hz[0], frequency_hz[-1], step_hz)
    lines = np.union1d(frequency_hz, between)
    finer = [np.interp(lines, frequency_hz, each) for each in loci.T]
    return _limits(lines, np.stack(finer, axis=1), cut, speed_rpm)


def _lines(modes: ToolModes, slowest_s: float) -> Real:
    """Return where the loci of modes are looked at [Hz]."""
    step_hz = TURN_STEP_RAD / (2.0 * math.pi * slowest_s)
    evenly = np.arange(step_hz, ABOVE * modes.frequency_hz.max(), step_hz)
    # Dense at a mode, ever coarser away from it: even steps of asinh.
    steps = np.sinh(np.linspace(-8.0, 8.0, round(16.0 * PER_BANDWIDTH) + 1))
    width = modes.damping_ratio * modes.frequency_hz
    near = (modes.frequency_hz[:, None] + width[:, None] * steps).ravel()
    return np.union1d(evenly, near[(near > 0.0) & (near < ABOVE * modes.frequency_hz.max())])


def _loci(receptance: Complex, cut: Cut) -> Complex:
    """Return the eigenvalues of G D, each followed over frequency, (n_lines, 3)."""
    values = np.asarray(np.linalg.eigvals(receptance @ cut.mean_directional), np.complex128)
    orders = np.array(list(permutations(range(values.shape[1]))))
    step = np.abs(values[1:, orders] - values[:-1, None, :]).sum(axis=2)
    nearest = orders[np.argmin(step, axis=1)]
    # A step's order is that of the values as they came; chain them.
    order, chained = np.arange(values.shape[1]), [np.arange(values.shape[1])]
    for each in nearest:
        order = each[order]
        chained.append(order)
    return values[np.arange(len(values))[:, None], np.array(chained)]


def _limits(lines_hz: Real, loci: Complex, cut: Cut, speed_rpm: Real) -> Limits:
    speeds = np.atleast_1d(np.asarray(speed_rpm, float))
    found = [_limit(lines_hz, loci, cut.cutter.tooth_period_s(speed)) for speed in speeds]
    depth, chatter = np.array(found).reshape(-1, 2).T
    return Limits(speeds, depth, chatter)


def _limit(lines_hz: Real, loci: Complex, period_s: float) -> tuple[float, float]:
    """Return limiting depth and chatter frequency of one speed."""
    turned = loci * (1.0 - np.exp(-2j * np.pi * lines_hz * period_s))[:, None]
    below, above = turned[:-1], turned[1:]
    crossed = below.imag * above.imag < 0.0
    with np.errstate(divide='ignore', invalid='ignore'):
        share = below.imag / (below.imag - above.imag)
    reach = np.where(crossed, below.real + share * (above.real - below.real), 0.0)
    line, locus = np.unravel_index(int(np.argmax(reach)), reach.shape)
    if reach[line, locus] <= 0.0:
        return math.inf, math.nan
    between = lines_hz[line] + share[line, locus] * (lines_hz[line + 1] - lines_hz[line])
    return 1.0 / float(reach[line, locus]), float(between)
