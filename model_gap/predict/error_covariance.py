"""What the noise of a measured twist makes of a prediction: part of a residual's covariance.

A torque that follows a measured twist inherits its noise.  The readings it makes lie along one
direction h(ω) per record and frequency, so that the residual's covariance is D + s h hᴴ with D the
noise of the sensors and s(ω) the power of the torque's error.  The residual is scaled along h to
what it would be with covariance D, and all over by the root of the determinants' ratio: a law
that is doubtful where others are not pays for it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex, RecordSpectra
from model_gap.predict.thresholds import PREDICTION

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ErrorCovariance:
    """Covariance of the error of one record beyond its noise: uncertain directions.

    Parameters
    ----------
    directions : tuple of (n_channels, n_bins) array
        Unit vectors in readings over the noise.
    shrink : tuple of (n_bins,) array
        1 - 1/√(1 + s|h|²) of each.
    log_det : float
        Σ log(1 + s|h|²).
    """

    directions: tuple[Complex, ...]
    shrink: tuple[Array, ...]
    log_det: float


def error_covariance(
    responses: Sequence[Complex], errors: Sequence[Complex], item: RecordSpectra
) -> ErrorCovariance:
    """Return the covariance of what errors of torques make of the readings.

    Parameters
    ----------
    responses : sequence of (n_channels, n_bins) array
        Readings per torque.
    errors : sequence of (n_bins,) array
        A sample of every torque's error.
    item : RecordSpectra
        Gives the noise.
    """
    directions, shrink, log_det = [], [], 0.0
    for response, error in zip(responses, errors, strict=True):
        scaled = item.over_noise(response)
        size = np.sqrt(np.sum(np.abs(scaled) ** 2, axis=0))
        window = np.ones(2 * PREDICTION.power_neighbours + 1)
        power = np.convolve(np.abs(error) ** 2, window, 'same')
        power /= np.convolve(np.ones(len(error)), window, 'same')
        growth = 1.0 + power * size**2
        directions.append(scaled / np.maximum(size, 1e-300))
        shrink.append(1.0 - 1.0 / np.sqrt(growth))
        log_det += float(np.log(growth).sum())
    return ErrorCovariance(tuple(directions), tuple(shrink), log_det)


def whitened(values: Complex, covariance: ErrorCovariance, item: RecordSpectra) -> Complex:
    """Return readings whitened along the uncertain directions, (n_channels, n_bins)."""
    scaled = item.over_noise(values)
    for direction, shrink in zip(covariance.directions, covariance.shrink, strict=True):
        scaled = scaled - direction * (shrink * np.sum(direction.conj() * scaled, axis=0))
    return item.from_noise(scaled)
