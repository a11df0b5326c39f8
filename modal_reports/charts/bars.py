"""Bars with their deviation, beside a line to compare with."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math

from markupsafe import Markup

from modal_reports.charts import svg

WIDTH, LEFT, LONGEST, STEP, THICK = 460, 158, 240, 30, 22


@dataclass(frozen=True, slots=True)
class Bar:
    """One bar.

    Parameters
    ----------
    name : str
        Before it.
    value : float
        Its length; a bar that is not finite is left out.
    kind : str
        Class name: ``before``, ``after``.
    std : float
        Standard deviation, an error bar of ±2 σ; NaN for none.
    """

    name: str
    value: float
    kind: str
    std: float = math.nan


def bar_chart(
    label: str, bars: Sequence[Bar], words: Callable[[float], str], level: tuple[str, float]
) -> Markup:
    """Draw bars to the right from nought.

    Parameters
    ----------
    label : str
        What the picture shows.
    bars : sequence of Bar
        From top to bottom.
    words : callable
        Text of a value.
    level : (name, value)
        A line across all bars.
    """
    shown = [bar for bar in bars if math.isfinite(bar.value)]
    ends = [bar.value + _reach(bar) for bar in shown]
    scale = LONGEST / max(*ends, level[1], 1e-6)
    parts = []
    for number, bar in enumerate(shown):
        parts += _bar(bar, 8 + STEP * number, scale, words(bar.value))
    bottom = 8 + STEP * len(shown)
    place = LEFT + scale * level[1]
    parts.append(svg.line('noise', (place, 2), (place, bottom)))
    parts.append(svg.text(place + 4, bottom + 10, level[0]))
    return svg.svg((WIDTH, bottom + 16), label, parts)


def _reach(bar: Bar) -> float:
    return 2.0 * bar.std if bar.std > 0.0 else 0.0


def _bar(bar: Bar, top: float, scale: float, words: str) -> list[str]:
    length, reach = scale * bar.value, scale * _reach(bar)
    parts = [
        svg.text(LEFT - 8, top + 15, bar.name, anchor='end'),
        svg.rectangle(f'bar {bar.kind}', LEFT, top, length, THICK),
    ]
    if reach:
        middle = top + THICK / 2
        ends = (LEFT + max(length - reach, 0.0), LEFT + length + reach)
        parts.append(svg.line('error', (ends[0], middle), (ends[1], middle)))
        parts += [svg.line('error', (x, middle - 4), (x, middle + 4)) for x in ends]
    return [*parts, svg.text(LEFT + 6 + length + reach, top + 15, words)]
