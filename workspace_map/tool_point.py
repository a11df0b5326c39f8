"""Frequency response of the tool point from predicted modes, with its standard deviation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.tool_modes import PER_MODE, ToolModes
from workspace_map.predicted import PredictedModes

Array = NDArray[np.float64]
DRAWS = 200
"""Of the modes: a resonance is not Gaussian in f as soon as σ_f is near its half width."""


@dataclass(frozen=True)
class ToolPointResponse:
    """Displacement of the tool point per force on it, along the tool's axes.

    Parameters
    ----------
    frequency_hz : (n_frequencies,) array [Hz]
        Where.
    receptance : (n_frequencies, 3, 3) complex array [m/N]
        Displacement along the second index per force along the third.
    std : (n_frequencies, 3, 3) array [m/N]
        Standard deviation: root mean square distance of what the modes may be.
    low, high : (n_frequencies, 3, 3) array [m/N]
        The magnitude is between them with a probability of 90 %.
    """

    frequency_hz: Array
    receptance: NDArray[np.complex128]
    std: Array
    low: Array
    high: Array


def receptance(modes: PredictedModes, frequency_hz: ArrayLike) -> NDArray[np.complex128]:
    """Return Σ φ φᵀ / (ω_r² - ω² + 2jζω_r ω) + R, (n_frequencies, 3, 3) [m/N]."""
    omega = 2.0 * np.pi * np.atleast_1d(np.asarray(frequency_hz, dtype=float))[:, None]
    own = 2.0 * np.pi * modes.frequency_hz
    gain = 1.0 / (own**2 - omega**2 + 2j * modes.damping_ratio * own * omega)
    shapes = modes.tool_shapes
    return np.asarray(np.einsum('fm,am,bm->fab', gain, shapes, shapes) + modes.residual)


def tool_point_response(modes: PredictedModes, frequency_hz: ArrayLike) -> ToolPointResponse:
    """Return the response of the tool point with its standard deviation, by draws of the modes."""
    frequencies = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
    mean = receptance(modes, frequencies)
    drawn = np.array([receptance(each, frequencies) for each in modes.draws(DRAWS)])
    std = np.sqrt(np.mean(np.abs(drawn - mean) ** 2, axis=0))
    low, high = np.quantile(np.abs(drawn), (0.05, 0.95), axis=0)
    return ToolPointResponse(frequencies, mean, std, low, high)


def tool_modes(predicted: PredictedModes) -> ToolModes:
    """Return predicted modes with their covariance, mode after mode.

    Parameters
    ----------
    predicted : PredictedModes
        Of a map, along the tool's axes.
    """
    n = len(predicted)
    mode = np.arange(n)[:, None]
    order = np.hstack([mode, n + mode, 2 * n + (PER_MODE - 2) * mode + np.arange(3)]).ravel()
    return ToolModes(
        predicted.frequency_hz,
        predicted.damping_ratio,
        predicted.tool_shapes.T.copy(),
        predicted.covariance[np.ix_(order, order)],
    )
