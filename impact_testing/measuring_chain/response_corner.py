"""A high-pass of the responses: it turns the residues of real modes by arctan(ω_c / ω).

That grows towards low frequencies; a delay of the force turns them by ω τ.  Which of the two it
is the modes say by how well they agree.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from impact_testing.fit import start_poles
from impact_testing.measuring_chain.corner import Corner, NO_CORNER
from impact_testing.measuring_chain.phases import common_phases
from impact_testing.responses import PointData

Real = NDArray[np.float64]
TWO_PI = 2.0 * np.pi
CHANCE = 1e-3
"""Of real modes, or complex ones without a common sign, whose phases look like a high-pass."""
COMPLEX = 0.01
"""Phases of structures' own that are no surprise [rad]."""
FEWEST_MODES = 2.5
"""That tell as much as the surest: two phases have a scatter that says little."""
LEAST_SHARE = 2e-3
"""Of the lowest mode's frequency: less turns no residue by more than 0.1 degrees."""
NEARER = 0.5
"""Share of the phases that the force's corner leaves at most where responses have it too."""
ROUNDS = 2
"""The first leaves phases so small that the second tells the corner to a thousandth."""
Undone = Callable[[Corner], list[PointData]]


def without_corner(
    data: list[PointData], undone: Undone, of_force: Corner
) -> tuple[list[PointData], Corner]:
    """Estimate the corner that all responses have, and return them without it.

    Parameters
    ----------
    data : list of PointData
        As they are.
    undone : callable
        Returns them without a high-pass.
    of_force : Corner
        Of the force: responses are coupled alike as a rule, which one mode or two can show.
    """
    corner = NO_CORNER
    if of_force.sure:
        alike = undone(of_force)
        if _left(alike) < NEARER * _left(data):
            corner, data = of_force, alike
    for _ in range(ROUNDS):
        now = _by_phases(data, corner.hz if corner.sure else 0.0)
        if not now.sure:
            break
        corner, data = now, undone(now)
    return data, corner


def _left(data: Sequence[PointData]) -> float:
    """Return the phases of the modes, root of the weighted mean square [rad]."""
    pole = start_poles(data)
    if not len(pole):
        return 0.0
    phase, std = common_phases(data, pole)
    return float(np.sqrt(np.average(phase**2, weights=1.0 / (std**2 + COMPLEX**2))))


def _by_phases(data: Sequence[PointData], undone_hz: float) -> Corner:
    """Return the corner by the phases that are left beside what was undone."""
    pole = start_poles(data)
    if not len(pole):
        return NO_CORNER
    size_hz = np.abs(pole) / TWO_PI
    phase, std = common_phases(data, pole)
    weight = 1.0 / (std**2 + COMPLEX**2)
    n_told = float(weight.sum() ** 2 / np.sum(weight**2))
    if n_told < FEWEST_MODES:
        return NO_CORNER
    lead = np.arctan(undone_hz / size_hz) + phase
    slope, slope_std, left = _line(1.0 / size_hz, np.tan(lead), weight, n_told)
    late = _line(size_hz, lead, weight, n_told)
    chance = 2.0 * float(student.sf(abs(slope) / max(slope_std, 1e-300), n_told - 1.0))
    sure = chance < CHANCE and left < late[2] and slope > LEAST_SHARE * float(size_hz.min())
    return Corner(slope, slope_std, sure=sure)


def _line(x: Real, y: Real, weight: Real, n_told: float) -> tuple[float, float, float]:
    """Return the slope of a line through the origin, its deviation, and the sum left over."""
    size = float(np.sum(weight * x**2))
    slope = float(np.sum(weight * x * y)) / size
    left = float(np.sum(weight * (y - slope * x) ** 2))
    return slope, float(np.sqrt(left / (n_told - 1.0) / size)), left
