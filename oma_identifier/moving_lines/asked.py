"""Which orders of a shaft whose course is known are there, with a stated rate of errors.

In the shaft's own time an order is in the first cosine coefficients of what is turned back by it;
the next ones tell what response is usual beside it.  Of responses to random forces both have the
same covariance, and the trace of the one over the other has a known mean and variance (Lawley
and Hotelling's, of complex values): it is compared with that of Fisher's ratio of the same two.

References
----------
Maiwald and Kraus (2000), doi:10.1049/ip-rsn:20000493 (moments of inverse Wishart matrices).
"""

import numpy as np
from numpy.typing import NDArray

from modal_core.numbers.chance import fisher_tail
from oma_identifier.moving_lines.course import Course
from oma_identifier.moving_lines.near_band import NearBand
from oma_identifier.moving_lines.thresholds import MOVING

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
LIGHTEST = 0.005
"""Damping ratio of the lightest mode that is thought of where an order crosses it.  Chosen: of 148
orders of 20 ramps (simulated) 7 are left, 6 with half of it and 8 with twice as much."""
BESIDE, LEAST_BESIDE = 2, 16
"""Coefficients beside a line that tell what is usual: of its own, and at least."""
BELL = 10.0
"""Fall of power from coefficients to those beside them that no resonance has: far from its middle
it falls with the square of the distance, by 10 at most between these.  Without it sines that
wander, and nothing else, left modes."""


def orders_there(near: NearBand, found_hz: Real, course: Course) -> list[tuple[float, int]]:
    """Return the orders of a shaft that are there beside those found, the surest first.

    Asked is about all multiples of the shafts of which the strongest order found may be one of
    the first.

    Parameters
    ----------
    near : NearBand
        Responses in the shaft's own time, without the orders that were found.
    found_hz : (n_found,) array [Hz]
        These, the strongest first.
    course : Course
        Of the shaft.

    Returns
    -------
    list of (float, int)
        Frequency [Hz], and how many cosine coefficients stand out.
    """
    apart_hz = MOVING.most_knots * near.rate_hz / near.n_rows
    asked_hz = [
        hz
        for hz in _multiples(found_hz[0], course, near.rate_hz)
        if min(abs(found_hz - hz)) >= apart_hz
    ]
    n_most = most_coefficients(course.moved)
    n_kept = n_most + LEAST_BESIDE + BESIDE * n_most
    sure = []
    for hz in asked_hz:
        chance, n_own = order_at(near.coefficients(hz, n_kept), n_most)
        if chance * len(asked_hz) < MOVING.wrong_order:
            sure.append((chance, hz, n_own))
    there: list[tuple[float, int]] = []
    for _, hz, n_own in sorted(sure):
        if all(abs(hz - other) >= apart_hz for other, _ in there):
            there.append((hz, n_own))
    return there


def _multiples(found_hz: float, course: Course, rate_hz: float) -> Real:
    """Return all multiples that are below half the sample rate at the highest speed [Hz]."""
    highest_hz = 0.5 * rate_hz / (1.0 + 0.5 * course.moved)
    parts = {*range(1, MOVING.lowest_order + 1)}
    if course.base_hz:
        parts.add(max(1, round(found_hz / course.base_hz)))
    ratios = {
        order / part for part in parts for order in range(1, int(highest_hz * part / found_hz) + 1)
    }
    return np.asarray(found_hz * np.array(sorted(ratios)))


def most_coefficients(moved: float) -> int:
    """Return how many coefficients an order may have that crosses the lightest mode."""
    return min(MOVING.most_knots, 2 + int(moved / LIGHTEST))


def extent(level: Complex, n_most: int) -> int:
    """Return how many coefficients stand out of those that follow, 0: none.

    More than an order may have belong to it where they fall faster than the bell of a mode can.
    """
    n_line, first, last = 0, 0, 1
    while last <= MOVING.most_knots:
        own, beside = level[first:last], level[last : last + LEAST_BESIDE + BESIDE * last]
        if len(beside) < LEAST_BESIDE:
            break
        fall = np.mean(np.abs(own) ** 2, axis=0) > BELL * np.mean(np.abs(beside) ** 2, axis=0)
        if (last <= n_most or fall.any()) and chance_of(own, beside) < MOVING.wrong_order:
            n_line = last
        first, last = last, 2 * last
    return n_line


def order_at(level: Complex, n_most: int) -> tuple[float, int]:
    """Return the chance that a line's first coefficients are response, and how many they are.

    Parameters
    ----------
    level : (n_kept, n_channels) complex array
        Cosine coefficients of what is turned back by the line.
    n_most : int
        That the line may have.
    """
    best, n_line, n_asked = 1.0, 0, 0
    while (n_own := 2**n_asked) <= n_most:
        n_beside = LEAST_BESIDE + BESIDE * n_own
        if n_own + n_beside > len(level):
            break
        chance = chance_of(level[:n_own], level[n_own : n_own + n_beside])
        if chance < best:
            best, n_line = chance, n_own
        n_asked += 1
    return min(1.0, best * n_asked), n_line


def chance_of(own: Complex, beside: Complex) -> float:
    """Return the chance that values of one covariance have so large a trace over others.

    Parameters
    ----------
    own : (n_own, n_channels) complex array
    beside : (n_beside, n_channels) complex array
        At least four more than channels.
    """
    size = np.sqrt(np.mean(np.abs(beside) ** 2, axis=0))
    size = np.where(size > 0.0, size, 1.0)
    values, vectors = np.linalg.eigh((beside / size).conj().T @ (beside / size))
    shown = values > len(values) * np.finfo(float).eps * values.max(initial=0.0)
    turned = (own / size) @ vectors[:, shown]
    trace = float(np.sum(np.abs(turned) ** 2 / values[shown]))
    n, m, p = len(own), len(beside), int(np.count_nonzero(shown))
    if p == 0:
        return 1.0
    free = m - p
    mean = n * p / free
    scale = 1.0 / (free**2 - 1.0)
    square = scale * (p**2 + p / free)
    variance = n * scale * p * m / free + n**2 * (square - (p / free) ** 2)
    above, spread = 2.0 * n * p, variance / mean**2
    below = (4.0 * spread * above + 2.0 * above - 4.0) / (spread * above - 2.0)
    return float(fisher_tail(trace / mean * below / (below - 2.0), above, below))
