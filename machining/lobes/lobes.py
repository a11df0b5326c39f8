"""Stability lobes of a tool: charts of all directions, the best as a whole, proposals."""

from dataclasses import dataclass

import numpy as np

from machining.cut_settings import CutSettings
from machining.lobes.chart import Chart, mean_chart, Tool, whole_chart
from machining.lobes.propose import forced, Proposal, propose
from machining.task import cut_of, speeds_of
from modal_core.errors import SettingsError
from modal_core.tool_modes import ToolModes
from modal_core.work.progress import Progress

DIRECTIONS = (0.0, 90.0)
FEW_LOBES = 0.15
"""Cycles of a mode per tooth period below which lobes are no help: the first alone is near."""


@dataclass(frozen=True, slots=True)
class Lobes:
    """What is known of a tool's cuts.

    Parameters
    ----------
    settings : CutSettings
    charts : tuple of Chart
        A direction each; the first is the one proposals are made for, as a whole.
    proposals : tuple of Proposal
        Best first.
    remarks : tuple of str
        What should be known of them.
    """

    settings: CutSettings
    charts: tuple[Chart, ...]
    proposals: tuple[Proposal, ...]
    remarks: tuple[str, ...]


def stability_lobes(
    tool: Tool, settings: CutSettings, progress: Progress = lambda _: None
) -> Lobes:
    """Return limits over speed, the chance of chatter, and cuts to take.

    Parameters
    ----------
    tool : ToolModes or ToolResponse
        In its own axes, which ``settings`` relate to spindle and feed.
    settings : CutSettings
    progress : callable
        Takes the fraction done.

    Raises
    ------
    SettingsError
        The tool's response does not reach where it would chatter.
    """
    charts = [mean_chart(tool, settings, each) for each in settings.feed_deg or DIRECTIONS]
    _check_band(tool, charts)
    speed = speeds_of(settings)
    calm = ~forced(tool, settings, speed)
    deepest = settings.max_depth_mm * 1e-3

    def takes(chart: Chart) -> float:
        return float(np.max(np.minimum(chart.mean.depth_m, deepest) * speed * calm))

    charts.sort(key=takes, reverse=True)
    charts[0] = whole_chart(charts[0], tool, settings, progress)
    progress(1.0)
    proposals = propose(charts[:1], tool, settings)
    return Lobes(settings, tuple(charts), proposals, tuple(_remarks(tool, settings, charts[0])))


def _check_band(tool: Tool, charts: list[Chart]) -> None:
    """Refuse a response in which chatter is found only at its ends, or not at all."""
    if isinstance(tool, ToolModes):
        return
    lines = tool.frequency_hz
    found = np.concatenate([chart.mean.chatter_hz for chart in charts])
    found = found[np.isfinite(found)]
    if not len(found):
        raise SettingsError(
            'nothing would chatter within the response',
            found=f'{lines[0]:g} to {lines[-1]:g} Hz',
            advice='its lines must reach over the modes of the tool',
        )


def _remarks(tool: Tool, settings: CutSettings, chart: Chart) -> list[str]:
    said = []
    if chart.sample is None:
        said.append(
            'no σ is known of modes or coefficients, so no chance of chatter either: proposals '
            'stay a fifth below the limit by convention'
        )
    if not isinstance(tool, ToolModes):
        said.append(
            'a measured response knows the mean force only: chatter of doubled period at small '
            'radial depths is not seen'
        )
    elif settings.theory == 'mean':
        said.append('the mean force alone: chatter of doubled period is not seen')
    slowest_s = cut_of(settings).cutter.tooth_period_s(settings.max_speed_rpm)
    if isinstance(tool, ToolModes):
        low = tool.frequency_hz[tool.frequency_hz * slowest_s < FEW_LOBES]
        if len(low):
            said.append(
                f'modes up to {low.max():.3g} Hz are far below tooth passing: their limit hardly '
                'depends on the speed'
            )
    if forced(tool, settings, speeds_of(settings)).all():
        said.append('at every speed teeth pass near a mode: no cut is proposed')
    return said
