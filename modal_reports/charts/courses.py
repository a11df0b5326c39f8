"""Curves over a linear axis, with a band and marks, as a still picture."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_reports.charts import svg
from modal_reports.charts.lines import round_step

Array = NDArray[np.float64]
SIZE = (920, 340)
LEFT, RIGHT, TOP, BOTTOM = 48, 16, 26, 34


@dataclass(frozen=True, slots=True)
class Mark:
    """A point of interest: where, and what is said when it is pointed at."""

    x: float
    y: float
    words: str


def course_plot(
    title: str,
    names: tuple[str, str],
    x: Array,
    curves: Sequence[tuple[str, Array]],
    highest: float,
    band: tuple[Array, Array] | None = None,
    marks: Sequence[Mark] = (),
) -> Markup:
    """Draw curves over x; what is above the picture, or infinite, lies on its upper edge.

    Parameters
    ----------
    title : str
        Above the picture.
    names : (str, str)
        Of both axes, with units.
    x : (n,) array
        Rising.
    curves : sequence of (class name, (n,) array)
        ``measured``, ``before``, ``after``.
    highest : float
        Upper end of the picture; the lower is 0.
    band : (low, high) of (n,) arrays, or None
        Filled.
    marks : sequence of Mark
        Dots.
    """
    frame = _Frame(float(x[0]), float(x[-1]), highest)
    parts = [svg.text(LEFT, 15, title, 'title')]
    if band is not None:
        edge = [*frame.points(x, band[0]), *reversed(frame.points(x, band[1]))]
        parts.append(svg.polygon('two', edge))
    parts += frame.grid(names)
    parts += [svg.polyline(kind, frame.points(x, values)) for kind, values in curves]
    parts += [svg.circle('dot', frame.x(at.x), frame.y(at.y), 4.0, at.words) for at in marks]
    return svg.svg(SIZE, title, parts)


@dataclass(frozen=True, slots=True)
class _Frame:
    """Where values are in the picture."""

    first: float
    last: float
    highest: float

    def x(self, value: float) -> float:
        share = (value - self.first) / (self.last - self.first or 1.0)
        return LEFT + (SIZE[0] - LEFT - RIGHT) * share

    def y(self, value: float) -> float:
        share = min(max(value / self.highest, 0.0), 1.0)
        return TOP + (SIZE[1] - TOP - BOTTOM) * (1.0 - share)

    def points(self, x: Array, values: Array) -> list[tuple[float, float]]:
        return [(self.x(a), self.y(b)) for a, b in zip(x.tolist(), values.tolist(), strict=True)]

    def grid(self, names: tuple[str, str]) -> Iterator[str]:
        step = round_step(self.highest)
        for number in range(int(self.highest / step + 1e-9) + 1):
            y = self.y(number * step)
            yield svg.line('grid', (LEFT, y), (SIZE[0] - RIGHT, y))
            yield svg.text(LEFT - 5, y + 4, f'{number * step:g}', anchor='end')
        step = round_step(self.last - self.first)
        for number in range(math.ceil(self.first / step), math.floor(self.last / step) + 1):
            x = self.x(number * step)
            yield svg.text(x, SIZE[1] - 16, f'{number * step:g}', anchor='middle')
        yield svg.text(SIZE[0] - RIGHT, SIZE[1] - 2, names[0], anchor='end')
        yield svg.text(SIZE[0] - RIGHT, 15, names[1], anchor='end')
