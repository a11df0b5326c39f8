"""Curves over frequency, as a still picture."""

from collections.abc import Sequence

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_reports.charts import svg

Array = NDArray[np.float64]
SMALL, LARGE = (460, 210), (920, 300)
LEFT, RIGHT, TOP, BOTTOM = 44, 10, 26, 30
LEAST_DECADES = 1.5
TINY = 1e-12


def spectrum_plot(
    title: str,
    frequency_hz: Array,
    curves: Sequence[tuple[str, Array]],
    level: float,
    size: tuple[int, int] = SMALL,
) -> Markup:
    """Draw amplitudes over frequency, logarithmic, one curve per name.

    Parameters
    ----------
    title : str
        Above the picture.
    frequency_hz : (n,) array [Hz]
        Abscissa.
    curves : sequence of (class name, (n,) array)
        ``measured``, ``before``, ``after``.
    level : float
        Of the noise, a dashed line.
    size : (width, height)
        Of the picture.
    """
    axes = _Axes(frequency_hz, curves, level, size)
    parts = [svg.text(LEFT, 15, title, 'title'), *axes.grid()]
    parts.append(svg.line('noise', (LEFT, axes.y(level)), (size[0] - RIGHT, axes.y(level))))
    for name, values in curves:
        points = zip(map(axes.x, frequency_hz.tolist()), map(axes.y, values.tolist()), strict=True)
        parts.append(svg.polyline(name, points))
    return svg.svg(size, title, parts)


class _Axes:
    """Where a frequency and an amplitude are in the picture."""

    def __init__(
        self,
        frequency_hz: Array,
        curves: Sequence[tuple[str, Array]],
        level: float,
        size: tuple[int, int],
    ) -> None:
        highest = max(float(values.max()) for _, values in curves)
        self._high = float(np.log10(max(highest, TINY))) + 0.1
        bottom = float(np.log10(max(level, TINY)))
        self._low = min(bottom, self._high - LEAST_DECADES) - 0.2
        self._first, self._last = float(frequency_hz[0]), float(frequency_hz[-1])
        self._width, self._height = size

    def x(self, frequency_hz: float) -> float:
        """Return the place along the picture."""
        share = (frequency_hz - self._first) / (self._last - self._first or 1.0)
        return LEFT + (self._width - LEFT - RIGHT) * share

    def y(self, amplitude: float) -> float:
        """Return the place down the picture; what is below its foot lies on it."""
        share = (float(np.log10(max(amplitude, TINY))) - self._low) / (self._high - self._low)
        return TOP + (self._height - TOP - BOTTOM) * (1.0 - min(max(share, 0.0), 1.0))

    def grid(self) -> list[str]:
        """Return lines at the decades and the numbers of both axes."""
        right = self._width - RIGHT
        parts = []
        for decade in range(int(np.ceil(self._low)), int(np.floor(self._high)) + 1):
            y = self.y(10.0**decade)
            parts.append(svg.line('grid', (LEFT, y), (right, y)))
            parts.append(svg.text(LEFT - 5, y + 4, f'1e{decade}', anchor='end'))
        step = round_step(self._last - self._first)
        first = np.ceil(self._first / step) * step
        for tick in np.arange(first, self._last + 1e-9 * step, step).tolist():
            parts.append(svg.text(self.x(tick), self._height - 12, f'{tick:g}', anchor='middle'))
        parts.append(svg.text(right, self._height - 1, 'Hz', anchor='end'))
        return parts


def round_step(span: float) -> float:
    """Return a round distance between the numbers of an axis, about six of them."""
    decade = 10.0 ** np.floor(np.log10(span / 6.0)) if span > 0.0 else 1.0
    return float(next(decade * step for step in (1, 2, 5, 10) if span / (decade * step) <= 10.0))
