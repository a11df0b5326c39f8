"""Mode shapes in the complex plane: a real mode lies on one line, a complex one fans out."""

from collections.abc import Iterator, Sequence

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_reports.charts import svg

SIDE, RADIUS, TOP, IN_A_ROW = 150, 58, 22, 6
MIDDLE = SIDE / 2


def complexity_plot(label: str, shapes: Sequence[tuple[str, NDArray[np.complex128]]]) -> Markup:
    """Draw every point of every shape as a line from nought, a panel per mode.

    Parameters
    ----------
    label : str
        What the picture shows.
    shapes : sequence of (title, (n_channels,) complex array)
        Each to its own scale, the largest entry on the circle; what is not finite is left out.
    """
    n_rows = -(-len(shapes) // IN_A_ROW)
    parts: list[str] = []
    for number, (title, shape) in enumerate(shapes):
        row, column = divmod(number, IN_A_ROW)
        parts += _panel(column * SIDE, row * (SIDE + TOP), title, shape)
    return svg.svg((IN_A_ROW * SIDE, n_rows * (SIDE + TOP)), label, parts)


def _panel(left: float, top: float, title: str, shape: NDArray[np.complex128]) -> Iterator[str]:
    x, y = left + MIDDLE, top + TOP + MIDDLE
    yield svg.text(x, top + 16, title, 'title', 'middle')
    yield svg.circle('rim', x, y, RADIUS)
    yield svg.line('grid', (x - RADIUS, y), (x + RADIUS, y))
    yield svg.line('grid', (x, y - RADIUS), (x, y + RADIUS))
    known = shape[np.isfinite(shape)]
    largest = float(np.abs(known).max(initial=0.0))
    if not largest:
        return
    for entry in known / largest * RADIUS:
        end = (x + float(entry.real), y - float(entry.imag))
        yield svg.line('point', (x, y), end)
        yield svg.circle('dot', *end, 2.0)
