"""Pictures as SVG: spectra before and after, the map of the gap, bars of evidence."""

from collections.abc import Sequence

from markupsafe import escape, Markup
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WIDTH, HEIGHT = 460, 210
LEFT, RIGHT, TOP, BOTTOM = 44, 10, 26, 30


def spectra_plot(
    title: str,
    frequency_hz: Array,
    lines: Sequence[tuple[str, Array]],
    noise: float,
    size: tuple[int, int] = (WIDTH, HEIGHT),
) -> Markup:
    """Draw amplitudes over frequency, logarithmic, one polyline per named line.

    Parameters
    ----------
    title : str
        Above the picture.
    frequency_hz : (n,) array [Hz]
        Abscissa.
    lines : sequence of (class name, (n,) array)
        Measured, before, after.
    noise : float
        Level of the noise, a dashed line.
    size : (width, height)
        Of the picture.
    """
    width, height = size
    everything = np.concatenate([values for _, values in lines])
    high = float(np.log10(max(everything.max(), 1e-12))) + 0.1
    low = min(float(np.log10(max(noise, 1e-12))), high - 1.5) - 0.2
    span = float(frequency_hz[-1] - frequency_hz[0]) or 1.0

    def x(value: float) -> float:
        return LEFT + (width - LEFT - RIGHT) * (value - float(frequency_hz[0])) / span

    def y(value: float) -> float:
        share = (float(np.log10(max(value, 1e-12))) - low) / (high - low)
        return TOP + (height - TOP - BOTTOM) * (1.0 - min(max(share, 0.0), 1.0))

    parts = [f'<text class="title" x="{LEFT}" y="15">{escape(title)}</text>']
    for decade in range(int(np.ceil(low)), int(np.floor(high)) + 1):
        level = y(10.0**decade)
        parts.append(
            f'<line class="grid" x1="{LEFT}" x2="{width - RIGHT}" y1="{level:.1f}" '
            f'y2="{level:.1f}"/><text class="tick" x="{LEFT - 5}" y="{level + 4:.1f}" '
            f'text-anchor="end">1e{decade}</text>'
        )
    for tick in range(10, int(frequency_hz[-1]) + 1, 10):
        parts.append(
            f'<text class="tick" x="{x(tick):.1f}" y="{height - 12}" '
            f'text-anchor="middle">{tick}</text>'
        )
    parts.append(
        f'<text class="tick" x="{width - RIGHT}" y="{height - 1}" text-anchor="end">Hz</text>'
    )
    parts.append(
        f'<line class="noise" x1="{LEFT}" x2="{width - RIGHT}" y1="{y(noise):.1f}" '
        f'y2="{y(noise):.1f}"/>'
    )
    for name, values in lines:
        points = ' '.join(
            f'{x(float(f)):.1f},{y(float(v)):.1f}'
            for f, v in zip(frequency_hz, values, strict=True)
        )
        parts.append(f'<polyline class="{escape(name)}" points="{points}"/>')
    body = ''.join(parts)
    return Markup(  # noqa: S704  numbers and escaped text only
        f'<svg viewBox="0 0 {width} {height}" role="img" aria-label="{escape(title)}">{body}</svg>'
    )


def heat(value: float) -> str:
    """Return the colour of so many times the noise: green at one, red from thirty."""
    share = min(max(float(np.log10(max(value, 1.0))) / 1.5, 0.0), 1.0)
    return f'hsl({130 - 130 * share:.0f} 55% {78 - 28 * share:.0f}%)'


def gap_map(rows: Sequence[str], columns: Sequence[str], before: Array, after: Array) -> Markup:
    """Draw what is left over of sensors by bands, before beside after.

    Parameters
    ----------
    rows, columns : sequence of str
        Sensors and bands.
    before, after : (n_rows, n_columns) array
        Times the noise.
    """
    cell, label, space = 40, 110, 60
    wide = len(columns) * cell
    width, height = label + 2 * wide + space, 46 + 24 * len(rows) + 30
    parts = []
    for offset, title, values in (
        (label, 'before', before),
        (label + wide + space, 'after', after),
    ):
        parts.append(f'<text class="title" x="{offset}" y="16">{title}</text>')
        for column, name in enumerate(columns):
            parts.append(
                f'<text class="tick" x="{offset + column * cell + cell / 2}" y="36" '
                f'text-anchor="middle">{escape(name)}</text>'
            )
        for row in range(len(rows)):
            for column in range(len(columns)):
                value = float(values[row, column])
                if not np.isfinite(value):
                    continue
                text = f'{value:.1f}' if value < 100 else f'{value:.0f}'
                parts.append(
                    f'<rect x="{offset + column * cell}" y="{44 + 24 * row}" width="{cell - 2}" '
                    f'height="22" fill="{heat(value)}"/>'
                    f'<text class="cell" x="{offset + column * cell + cell / 2 - 1}" '
                    f'y="{59 + 24 * row}" text-anchor="middle">{text}</text>'
                )
    for row, name in enumerate(rows):
        parts.append(
            f'<text class="tick" x="{label - 8}" y="{59 + 24 * row}" '
            f'text-anchor="end">{escape(name)}</text>'
        )
    return Markup(  # noqa: S704  numbers and escaped text only
        f'<svg class="wide" viewBox="0 0 {width} {height}" role="img" '
        f'aria-label="gap by sensor and band">{"".join(parts)}</svg>'
    )


def gap_bars(values: Sequence[tuple[str, float]], noise: float) -> Markup:
    """Draw gaps as bars with the noise floor as a line."""
    values = [(name, value) for name, value in values if np.isfinite(value)]
    largest = max([value for _, value in values] + [noise, 1e-6])
    parts = []
    for number, (name, value) in enumerate(values):
        top = 8 + 30 * number
        kind = 'after' if 'after' in name else 'before'
        parts.append(
            f'<text class="tick" x="150" y="{top + 15}" text-anchor="end">{escape(name)}</text>'
            f'<rect class="bar {kind}" x="158" y="{top}" '
            f'width="{240 * value / largest:.1f}" height="22"/>'
            f'<text class="tick" x="{164 + 240 * value / largest:.1f}" y="{top + 15}">'
            f'{100 * value:.1f} %</text>'
        )
    place = 158 + 240 * noise / largest
    bottom = 8 + 30 * len(values)
    parts.append(f'<line class="noise" x1="{place:.1f}" x2="{place:.1f}" y1="2" y2="{bottom}"/>')
    parts.append(f'<text class="tick" x="{place + 4:.1f}" y="{bottom + 10}">noise</text>')
    return Markup(  # noqa: S704  numbers and escaped text only
        f'<svg viewBox="0 0 {WIDTH} {bottom + 16}" role="img" aria-label="gap before and after">'
        f'{"".join(parts)}</svg>'
    )
