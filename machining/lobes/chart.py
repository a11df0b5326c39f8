"""Limits over speed for directions of feed, how sure they are, and what to do with them."""

from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from machining.cut import Cut
from machining.cut_settings import CutSettings
from machining.stability import (
    DepthSearch,
    is_uncertain,
    Limits,
    limits_of_modes,
    limits_of_periods,
    limits_of_response,
    LimitSample,
    LimitsOf,
    sampled_limits,
)
from machining.task import axes_of, cut_of, speeds_of, ToolResponse
from modal_core.tool_modes import ToolModes
from modal_core.work.progress import Progress

Real = NDArray[np.float64]
Tool = ToolModes | ToolResponse
SHALLOW = 0.25
"""Share of the least depth of the zeroth order at which the search for the limit begins: it is
within a factor of two where lobes of doubled period are not, and those lie deeper."""
SAMPLE_RATIO, SAMPLE_PRECISION, SAMPLE_FINER = 1.3, 0.01, 0.5
"""Of limits of samples, whose scatter is far above; what fewer steps change, they change for the
limit itself too, and it is taken out."""
SAMPLED_SPEEDS = 34
"""Of all speeds: between them the ratio of safe depth and limit is interpolated."""


@dataclass(frozen=True, slots=True)
class Chart:
    """Limits over speed for one direction of feed.

    Parameters
    ----------
    feed_deg : float [deg]
    mean : Limits
        By the zeroth order.
    periods : Limits or None
        By semi-discretisation; None of a measured response, or where not asked for.
    sample : LimitSample or None
        At some of the speeds; None where nothing is known to be uncertain, or not asked for.
    deepest_m : float [m]
        Depth up to which limits were looked for.
    """

    feed_deg: float
    mean: Limits
    deepest_m: float
    periods: Limits | None = None
    sample: LimitSample | None = None

    @property
    def limit(self) -> Limits:
        """The better of the two theories' limits."""
        return self.mean if self.periods is None else self.periods

    def safe_depth_m(self, risk: float) -> Real:
        """Return the depth that chatters at no more than a risk; the limit where none is known."""
        limit = self.limit
        if self.sample is None:
            return limit.depth_m
        sampled = np.isin(limit.speed_rpm, self.sample.speed_rpm)
        nominal = np.minimum(limit.depth_m, self.deepest_m)
        share = np.minimum(self.sample.quantile(risk), self.deepest_m) / nominal[sampled]
        return np.asarray(nominal * np.interp(limit.speed_rpm, self.sample.speed_rpm, share))


def mean_chart(tool: Tool, settings: CutSettings, feed_deg: float) -> Chart:
    """Return the chart of one direction by the zeroth order."""
    turned, cut = tool.turned(axes_of(settings, feed_deg)), cut_of(settings)
    deepest_m = settings.max_depth_mm * 1e-3
    if isinstance(turned, ToolModes):
        return Chart(feed_deg, limits_of_modes(turned, cut, speeds_of(settings)), deepest_m)
    found = limits_of_response(turned.frequency_hz, turned.receptance, cut, speeds_of(settings))
    return Chart(feed_deg, found, deepest_m)


def whole_chart(chart: Chart, tool: Tool, settings: CutSettings, progress: Progress) -> Chart:
    """Return a chart with limits by semi-discretisation, and how sure they are.

    Parameters
    ----------
    chart : Chart
        By the zeroth order.
    tool : ToolModes or ToolResponse
        In its own axes.
    settings : CutSettings
    progress : callable
        Takes the fraction done.
    """
    rng, cut = np.random.default_rng(settings.seed), cut_of(settings)
    turned = tool.turned(axes_of(settings, chart.feed_deg))
    if not isinstance(turned, ToolModes):
        return replace(chart, sample=_of_material(chart, settings, rng))
    if settings.theory == 'periods':
        search = depth_search(chart)
        limits = limits_of_periods(turned, cut, speeds_of(settings), search)
        chart = replace(chart, periods=limits)
    if not settings.n_samples or not is_uncertain(turned, cut):
        return chart
    quick = _quick_limits(chart, settings, progress)
    found = sampled_limits(turned, cut, quick, settings.n_samples, rng)
    nominal = quick(turned, cut)
    same = np.isin(chart.limit.speed_rpm, nominal.speed_rpm)
    limit = np.minimum(chart.limit.depth_m[same], chart.deepest_m)
    change = limit / np.minimum(nominal.depth_m, chart.deepest_m)
    return replace(chart, sample=replace(found, depth_m=found.depth_m * change))


def _quick_limits(chart: Chart, settings: CutSettings, progress: Progress) -> LimitsOf:
    """Return how limits of samples are found."""
    speeds, n_done = speeds_of(settings), 0
    if chart.periods is not None:
        speeds = speeds[:: math.ceil(len(speeds) / SAMPLED_SPEEDS)]
    quick = replace(depth_search(chart), ratio=SAMPLE_RATIO, precision=SAMPLE_PRECISION)

    def limits_of(modes: ToolModes, cut: Cut) -> Limits:
        nonlocal n_done
        n_done += 1
        progress(n_done / (settings.n_samples + 1))
        if chart.periods is None:
            return limits_of_modes(modes, cut, speeds)
        return limits_of_periods(modes, cut, speeds, quick, SAMPLE_FINER)

    return limits_of


def depth_search(chart: Chart) -> DepthSearch:
    """Return where limits are looked for, by those of the zeroth order."""
    least = min(float(chart.mean.depth_m.min()), chart.deepest_m)
    return DepthSearch(SHALLOW * least, chart.deepest_m)


def _of_material(
    chart: Chart, settings: CutSettings, rng: np.random.Generator
) -> LimitSample | None:
    """Return limits of samples of the material alone: they go with its reciprocal."""
    if not settings.n_samples or not settings.coefficients_std:
        return None
    factor = np.exp(settings.coefficients_std * rng.standard_normal((settings.n_samples, 1)))
    return LimitSample(chart.mean.speed_rpm, chart.mean.depth_m / factor)
