"""Damping over natural frequency, each mode with its ellipse of ±2 σ."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import math

from markupsafe import escape, Markup

from modal_reports.charts import svg
from modal_reports.charts.lines import round_step

WIDTH, HEIGHT = 920, 300
LEFT, RIGHT, TOP, BOTTOM = 48, 16, 14, 34
N_SIGMA = 2.0
DOT = 3.0


@dataclass(frozen=True, slots=True)
class PlacedMode:
    """A mode in the plane.

    Parameters
    ----------
    name : str
        Shown when it is pointed at.
    frequency_hz, damping_percent : float
        Where it is.
    frequency_std_hz, damping_std_percent : float
        Standard deviations; NaN where there is none.
    kind : str
        Class name of its colour: ``before``, ``after``, or none.
    """

    name: str
    frequency_hz: float
    damping_percent: float
    frequency_std_hz: float = math.nan
    damping_std_percent: float = math.nan
    kind: str = ''

    @property
    def reach(self) -> tuple[float, float]:
        """Half-axes of the ellipse, 0 where σ is not known."""
        return _reach(self.frequency_std_hz), _reach(self.damping_std_percent)


def _reach(std: float) -> float:
    return N_SIGMA * std if std > 0.0 else 0.0


def damping_plane(label: str, modes: Sequence[PlacedMode]) -> Markup:
    """Draw the modes; both axes are linear, damping from nought.

    Parameters
    ----------
    label : str
        What the picture shows.
    modes : sequence of PlacedMode
        One at least.
    """
    plane = _Plane(modes)
    parts = [*plane.grid()]
    for mode in modes:
        parts += plane.mark(mode)
    return svg.svg((WIDTH, HEIGHT), label, parts)


class _Plane:
    """Where a frequency and a damping ratio are in the picture."""

    def __init__(self, modes: Sequence[PlacedMode]) -> None:
        lowest = min(mode.frequency_hz - mode.reach[0] for mode in modes)
        highest = max(mode.frequency_hz + mode.reach[0] for mode in modes)
        margin = 0.06 * (highest - lowest or highest)
        self._first, self._last = max(lowest - margin, 0.0), highest + margin
        top = max(mode.damping_percent + mode.reach[1] for mode in modes)
        self._high = 1.1 * top or 1.0

    def x(self, frequency_hz: float) -> float:
        """Return the place along the picture."""
        share = (frequency_hz - self._first) / (self._last - self._first)
        return LEFT + (WIDTH - LEFT - RIGHT) * share

    def y(self, damping_percent: float) -> float:
        """Return the place down the picture."""
        return TOP + (HEIGHT - TOP - BOTTOM) * (1.0 - max(damping_percent, 0.0) / self._high)

    def grid(self) -> Iterator[str]:
        """Yield lines and numbers of both axes."""
        step = round_step(self._high)
        for number in range(int(self._high / step) + 1):
            y = self.y(number * step)
            yield svg.line('grid', (LEFT, y), (WIDTH - RIGHT, y))
            yield svg.text(LEFT - 5, y + 4, f'{number * step:g}', anchor='end')
        step = round_step(self._last - self._first)
        first, last = math.ceil(self._first / step), math.floor(self._last / step)
        for number in range(first, last + 1):
            x = self.x(number * step)
            yield svg.text(x, HEIGHT - 16, f'{number * step:g}', anchor='middle')
        yield svg.text(WIDTH - RIGHT, HEIGHT - 2, 'natural frequency [Hz]', anchor='end')
        yield svg.text(4, TOP - 3, 'damping [%]')

    def mark(self, mode: PlacedMode) -> Iterator[str]:
        """Yield the ellipse and the dot of a mode."""
        x, y = self.x(mode.frequency_hz), self.y(mode.damping_percent)
        wide, high = mode.reach
        if wide and high:
            rx = self.x(mode.frequency_hz + wide) - x
            ry = (HEIGHT - TOP - BOTTOM) * high / self._high
            place = f'cx="{x:.1f}" cy="{y:.1f}" rx="{max(rx, DOT):.1f}" ry="{max(ry, DOT):.1f}"'
            kind, title = escape(f'two {mode.kind}'.strip()), escape(mode.name)
            yield f'<ellipse class="{kind}" {place}><title>{title}</title></ellipse>'
        yield svg.circle(f'dot {mode.kind}'.strip(), x, y, DOT, mode.name)
