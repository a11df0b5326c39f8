"""Small pictures inside a table's cell."""

import math

from markupsafe import Markup

from modal_reports.charts import svg
from modal_reports.numbers import fixed

WIDTH, HEIGHT = 84, 16
MIDDLE = HEIGHT / 2
SIGMA, MOST_SIGMAS = 10.0, 4.0
FAR = 3.0


def meter(share: float) -> Markup:
    """Draw a share of the largest, 0 to 1; nothing where it is not known."""
    if not math.isfinite(share):
        return Markup('')
    inside = 80.0 * min(max(share, 0.0), 1.0)
    parts = (svg.rectangle('three', 0, 5, 80, 6), svg.rectangle('fill', 0, 5, inside, 6))
    return svg.svg((WIDTH, HEIGHT), f'{100.0 * share:.0f} % of the largest', parts, 'inline')


def error_mark(sigmas: float) -> Markup:
    """Draw an error in standard deviations on bands of one and three of them."""
    if not math.isfinite(sigmas):
        return Markup('')
    centre = WIDTH / 2
    place = centre + SIGMA * min(max(sigmas, -MOST_SIGMAS), MOST_SIGMAS)
    words = f'{fixed(sigmas, 1, sign=True)} σ'
    parts = (
        svg.rectangle('three', centre - 3 * SIGMA, 4, 6 * SIGMA, 8),
        svg.rectangle('one', centre - SIGMA, 4, 2 * SIGMA, 8),
        svg.line('zero', (centre, 1), (centre, HEIGHT - 1)),
        svg.circle('far' if abs(sigmas) > FAR else 'dot', place, MIDDLE, 3.2, words),
    )
    return svg.svg((WIDTH, HEIGHT), f'error {words}', parts, 'inline')
