"""Spindle speed, depth and direction of feed: as much material as is safe to take."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from machining.cut_settings import CutSettings
from machining.lobes.chart import Chart, Tool
from machining.stability import sampled_tools, spectral_radius
from machining.task import axes_of, cut_of
from modal_core.tool_modes import ToolModes

Real = NDArray[np.float64]
N_PROPOSALS = 3
APART = 0.1
"""Relative distance of two proposals' speeds: of one lobe the best is enough."""
FORCED_WIDTHS = 3.0
"""Half-power half-widths around a mode in which teeth do not pass: outside it answers with less
than a third of its peak (-10 dB)."""
ORDERS = (1, 2)
"""Of tooth passing; the force of higher ones is small."""
N_CHECKS = 200
MARGIN = 0.8
"""Of the limit, where nothing is known of how sure it is: a convention, and the remarks say so."""
SHALLOWER = 0.93
MOST_STEPS = 40


@dataclass(frozen=True, slots=True)
class Proposal:
    """A cut to take.

    Parameters
    ----------
    feed_deg : float [deg]
    speed_rpm, depth_m : float [rpm], [m]
    chance : float
        Of chatter, by samples of their own; NaN where nothing is known to be uncertain.
    chance_std : float
        Standard deviation of that, by the number of samples.
    """

    feed_deg: float
    speed_rpm: float
    depth_m: float
    chance: float
    chance_std: float


def propose(charts: list[Chart], tool: Tool, settings: CutSettings) -> tuple[Proposal, ...]:
    """Return the cuts that take most material per time at no more than the risk, best first.

    Parameters
    ----------
    charts : list of Chart
        Of the directions looked at as a whole.
    tool : ToolModes or ToolResponse
        In its own axes.
    settings : CutSettings
    """
    wanted: list[tuple[float, float, float, float]] = []
    for chart in charts:
        speed = chart.limit.speed_rpm
        depth = np.minimum(chart.safe_depth_m(settings.risk), settings.max_depth_mm * 1e-3)
        calm = ~forced(tool, settings, speed)
        wanted += [
            (float(n * a), chart.feed_deg, float(n), float(a))
            for n, a in zip(speed[calm], depth[calm], strict=True)
        ]
    chosen: list[tuple[float, float, float, float]] = []
    for each in sorted(wanted, reverse=True):
        if all(abs(each[2] / other[2] - 1.0) > APART for other in chosen):
            chosen.append(each)
        if len(chosen) == N_PROPOSALS:
            break
    made = [_checked(tool, settings, *each[1:]) for each in chosen]
    return tuple(sorted(made, key=lambda each: -each.speed_rpm * each.depth_m))


def forced(tool: Tool, settings: CutSettings, speed_rpm: Real) -> NDArray[np.bool_]:
    """Tell at which speeds teeth pass so near a mode that the forced vibration is large."""
    if not isinstance(tool, ToolModes):
        return np.zeros(len(speed_rpm), bool)
    relative = np.zeros(tool.n_modes)
    if tool.covariance is not None:
        relative = np.sqrt(np.diag(tool.covariance)[::5])
    width = FORCED_WIDTHS * (tool.damping_ratio + relative)
    near = np.zeros(len(speed_rpm), bool)
    for order in ORDERS:
        passing_hz = order * settings.n_teeth * speed_rpm / 60.0
        near |= (np.abs(passing_hz[:, None] / tool.frequency_hz - 1.0) < width).any(axis=1)
    return near


def _checked(
    tool: Tool, settings: CutSettings, feed_deg: float, speed_rpm: float, depth_m: float
) -> Proposal:
    """Return the proposal, made shallower until samples of its own bear it out."""
    turned, cut = tool.turned(axes_of(settings, feed_deg)), cut_of(settings)
    if _nothing_known(turned, settings):
        return Proposal(feed_deg, speed_rpm, MARGIN * depth_m, math.nan, math.nan)
    if not isinstance(turned, ToolModes) or settings.theory == 'mean':
        spread = math.sqrt(settings.risk / settings.n_samples)
        return Proposal(feed_deg, speed_rpm, depth_m, settings.risk, spread)
    tools = sampled_tools(turned, cut, N_CHECKS, np.random.default_rng(settings.seed + 1))
    share = 1.0
    for _ in range(MOST_STEPS):
        grows = [spectral_radius(*each, speed_rpm, depth_m) >= 1.0 for each in tools]
        share = float(np.mean(grows))
        if share <= settings.risk:
            break
        depth_m *= SHALLOWER
    spread = math.sqrt(max(share, 0.5 / N_CHECKS) / N_CHECKS)
    return Proposal(feed_deg, speed_rpm, depth_m, share, spread)


def _nothing_known(tool: Tool, settings: CutSettings) -> bool:
    """Tell whether nothing is known, or asked, of how sure a limit is."""
    known = isinstance(tool, ToolModes) and tool.covariance is not None
    return not settings.n_samples or not (known or settings.coefficients_std)
