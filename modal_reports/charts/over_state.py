"""A value with its deviation over the state it was measured in, as a still picture."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math

from markupsafe import Markup

from modal_reports.charts import svg
from modal_reports.charts.lines import round_step

SIZE = (460, 210)
LEFT, RIGHT, TOP, BOTTOM = 56, 16, 26, 34


@dataclass(frozen=True, slots=True)
class StatePoint:
    """A value: where on both axes, its deviation, and what is said when it is pointed at."""

    x: float
    y: float
    std: float
    words: str


def over_state(title: str, names: tuple[str, str], points: Sequence[StatePoint]) -> Markup:
    """Draw values with bars of two standard deviations, joined in the order of the state.

    Parameters
    ----------
    title : str
        Above the picture.
    names : (str, str)
        Of both axes, with units.
    points : sequence of StatePoint
        One at least; a deviation that is not known, NaN, has no bar.
    """
    frame = _Frame.around(points)
    course = sorted(points, key=lambda point: point.x)
    parts = [svg.text(LEFT, 15, title, 'title'), *frame.grid(names)]
    parts.append(svg.polyline('before', [(frame.x(at.x), frame.y(at.y)) for at in course]))
    for at in points:
        reach = 2.0 * at.std if math.isfinite(at.std) else 0.0
        x = frame.x(at.x)
        parts.append(svg.line('error', (x, frame.y(at.y - reach)), (x, frame.y(at.y + reach))))
        parts.append(svg.circle('dot', x, frame.y(at.y), 4.0, at.words))
    return svg.svg(SIZE, title, parts)


@dataclass(frozen=True, slots=True)
class _Frame:
    """Where values are in the picture."""

    left: float
    right: float
    low: float
    high: float
    is_counted: bool

    @classmethod
    def around(cls, points: Sequence[StatePoint]) -> '_Frame':
        """Return the frame that holds all points with their bars, and a little more."""
        reach = [2.0 * at.std if math.isfinite(at.std) else 0.0 for at in points]
        low = min(at.y - one for at, one in zip(points, reach, strict=True))
        high = max(at.y + one for at, one in zip(points, reach, strict=True))
        margin = 0.08 * (high - low) or 0.01 * abs(high) or 1.0
        left, right = min(at.x for at in points), max(at.x for at in points)
        beside = 0.05 * (right - left) or 0.5
        counted = all(float(at.x).is_integer() for at in points)
        return cls(left - beside, right + beside, low - margin, high + margin, counted)

    def x(self, value: float) -> float:
        share = (value - self.left) / (self.right - self.left)
        return LEFT + (SIZE[0] - LEFT - RIGHT) * share

    def y(self, value: float) -> float:
        share = (value - self.low) / (self.high - self.low)
        return TOP + (SIZE[1] - TOP - BOTTOM) * (1.0 - share)

    def grid(self, names: tuple[str, str]) -> Iterator[str]:
        step = round_step(self.high - self.low)
        for number in _multiples(self.low, self.high, step):
            y = self.y(number * step)
            yield svg.line('grid', (LEFT, y), (SIZE[0] - RIGHT, y))
            yield svg.text(LEFT - 5, y + 4, f'{number * step:g}', anchor='end')
        step = round_step(self.right - self.left)
        step = max(1.0, step) if self.is_counted else step
        for number in _multiples(self.left, self.right, step):
            yield svg.text(
                self.x(number * step), SIZE[1] - 16, f'{number * step:g}', anchor='middle'
            )
        yield svg.text(SIZE[0] - RIGHT, SIZE[1] - 2, names[0], anchor='end')
        yield svg.text(SIZE[0] - RIGHT, 15, names[1], anchor='end')


def _multiples(low: float, high: float, step: float) -> range:
    return range(math.ceil(low / step), math.floor(high / step) + 1)
