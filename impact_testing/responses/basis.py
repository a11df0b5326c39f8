"""Functions of frequency that FRFs are made of, as real numbers over the noise.

The accelerance of channel o to a force at i is
Σ_r [a / (jω - p) + conjugates] + c₀ + c₁ jω - c₂ ω² ...: real coefficients of the residual terms
hold the direct term, modes below and modes above.  With a as free as c₀ and c₁, s²R / (s - p) is
a / (s - p) with a = p² R.  All channels of a point have one course of noise over the lines, so one
set of basis functions serves them all.
"""

import numpy as np
from numpy.typing import NDArray

from impact_testing.responses.band_data import PointData

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]


def functions(data: PointData, pole: Complex) -> Real:
    """Return those of the poles over the noise, then the residual terms.

    Returns
    -------
    (2 n_lines, 2 n_poles + n_residual) array
    """
    basis = np.concatenate([bells(data, pole), residual_terms(data)], axis=1)
    return apart(basis / np.sqrt(data.course)[:, None])


def derivatives(data: PointData, pole: Complex) -> Real:
    """Return how those of the poles move with them, (2 n_lines, 2 n_poles) array."""
    near = 1e-4 * np.abs(pole.real)
    change = bells(data, pole + near) - bells(data, pole - near)
    return apart(change / np.repeat(2.0 * near, 2) / np.sqrt(data.course)[:, None])


def bells(data: PointData, pole: Complex) -> Complex:
    """Return what multiplies both parts of each amplitude, (n_lines, 2 n_poles) array."""
    upper, lower = data.terms(pole)
    both = np.stack([upper + lower, 1j * (upper - lower)], axis=-1)
    return np.asarray(both.reshape(len(upper), 2 * len(pole)))


def residual_terms(data: PointData) -> Complex:
    """Return the direct term and modes out of the band, (n_lines, n_residual) array."""
    share = 1j * data.frequency_hz / data.frequency_hz[-1]
    return np.asarray(share[:, None] ** np.arange(data.n_residual))


def apart(values: NDArray[np.inexact]) -> Real:
    """Return real parts, then imaginary parts, along the first axis."""
    return np.asarray(np.concatenate([values.real, values.imag]))
