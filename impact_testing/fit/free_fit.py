"""Amplitudes that every FRF has of its own: what shapes begin with and are checked against.

References
----------
Golub and Pereyra (1973), doi:10.1137/0710036 (variable projection).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from impact_testing.responses import apart, functions, PointData

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
RIDGE = 1e-11
"""Relative: keeps basis functions that are nearly alike from singular equations."""


@dataclass(frozen=True, slots=True)
class FreePoint:
    """One point at given poles.

    Parameters
    ----------
    amplitude : (n_poles, n_channels) complex array
        Of accelerances [m/s²/N · rad/s].
    cost : float
        Sum of squares that is left, in units of the noise.
    """

    amplitude: Complex
    cost: float


def free_fit(data: Sequence[PointData], pole: Complex) -> list[FreePoint]:
    """Solve for amplitudes and residual terms of each point, the poles given."""
    return [_solved(each, pole) for each in data]


def left_by(data: PointData, pole: Complex) -> Complex:
    """Return what poles with amplitudes of their own leave, (n_lines, n_channels) array.

    Over the level of the noise of each channel.
    """
    _, left = _coefficients(data, pole)
    half = len(left) // 2
    return np.asarray((left[:half] + 1j * left[half:]) * np.sqrt(data.course)[:, None])


def _solved(data: PointData, pole: Complex) -> FreePoint:
    coefficients, left = _coefficients(data, pole)
    parts = coefficients[: -data.n_residual]
    amplitude = (parts[::2] + 1j * parts[1::2]) * np.sqrt(data.level)
    return FreePoint(amplitude, float(np.sum(left**2)))


def _coefficients(data: PointData, pole: Complex) -> tuple[Real, Real]:
    """Return those of poles and residual terms, and what they leave, in units of the noise."""
    basis = functions(data, pole)
    target = apart(data.target)
    scale = np.linalg.norm(basis, axis=0)
    scaled = basis / scale
    factor = cho_factor(scaled.T @ scaled + RIDGE * np.eye(len(scale)))
    coefficients = cho_solve(factor, scaled.T @ target) / scale[:, None]
    return coefficients, target - basis @ coefficients
