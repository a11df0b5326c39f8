"""Curves of one number over another, both of any sign, as a still picture."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_reports.charts import svg
from modal_reports.charts.lines import round_step, SMALL

Array = NDArray[np.float64]
LEFT, RIGHT, TOP, BOTTOM = 54, 12, 26, 34
# Points of a curve that a picture of this size can show.
MOST_POINTS = 600


@dataclass(frozen=True, slots=True)
class Trace:
    """One curve.

    Parameters
    ----------
    kind : str
        Class name: ``measured``, ``before``, ``after``.
    x, y : (n,) array
        In the order in which they are joined.
    """

    kind: str
    x: Array
    y: Array


def trace_plot(
    title: str,
    names: tuple[str, str],
    traces: Sequence[Trace],
    size: tuple[int, int] = SMALL,
) -> Markup:
    """Draw curves in axes that hold all of them.

    Parameters
    ----------
    title : str
        Above the picture.
    names : (str, str)
        Of both axes, with units.
    traces : sequence of Trace
        From back to front.
    size : (width, height)
        Of the picture.
    """
    across = _Scale.of([item.x for item in traces], LEFT, size[0] - RIGHT)
    down = _Scale.of([item.y for item in traces], size[1] - BOTTOM, TOP)
    parts = [svg.text(LEFT, 15, title, 'title'), *_grid(across, down, names, size)]
    for item in traces:
        step = max(1, len(item.x) // MOST_POINTS)
        points = zip(item.x[::step].tolist(), item.y[::step].tolist(), strict=True)
        parts.append(svg.polyline(item.kind, [(across.at(a), down.at(b)) for a, b in points]))
    return svg.svg(size, title, parts)


@dataclass(frozen=True, slots=True)
class _Scale:
    """From values to places along one edge of the picture."""

    low: float
    high: float
    begin: float
    end: float

    @classmethod
    def of(cls, values: Sequence[Array], begin: float, end: float) -> '_Scale':
        low = min(float(item.min()) for item in values)
        high = max(float(item.max()) for item in values)
        wider = 0.04 * (high - low) or 1.0
        return cls(low - wider, high + wider, begin, end)

    def at(self, value: float) -> float:
        return self.begin + (self.end - self.begin) * (value - self.low) / (self.high - self.low)

    def ticks(self) -> list[float]:
        step = round_step(self.high - self.low)
        numbers = range(math.ceil(self.low / step), math.floor(self.high / step) + 1)
        return [number * step for number in numbers]


def _grid(
    across: _Scale, down: _Scale, names: tuple[str, str], size: tuple[int, int]
) -> Iterator[str]:
    for value in down.ticks():
        yield svg.line('grid', (LEFT, down.at(value)), (size[0] - RIGHT, down.at(value)))
        yield svg.text(LEFT - 5, down.at(value) + 4, f'{value:g}', anchor='end')
    for value in across.ticks():
        yield svg.text(across.at(value), size[1] - 16, f'{value:g}', anchor='middle')
    yield svg.text(size[0] - RIGHT, size[1] - 2, names[0], anchor='end')
    yield svg.text(size[0] - RIGHT, 15, names[1], anchor='end')
