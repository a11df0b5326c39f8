"""The noise of each channel, told from the motion that channels have in common."""

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.thresholds import LIKELIHOOD

Real = NDArray[np.float64]


def unexplained_scale(covariance: Real) -> Real:
    """Return 1/σ per channel, σ² what the other channels do not explain of it.

    Parameters
    ----------
    covariance : (n_channels, n_channels) array
        Of the channels.
    """
    root = np.sqrt(np.diag(covariance))
    # The ridge also bounds the scales of channels that are exact copies of others.
    correlation = covariance / np.outer(root, root) + 1e-7 * np.eye(len(root))
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(correlation))) / root)


def noise_scale(covariance: Real, n_lines: int) -> Real:
    """Return 1/σ per channel, σ² what no direction common to the channels explains of it.

    What the others do not explain is too much where a channel leads a motion.  Factor analysis by
    rounds, which approach the least residual: two of them go far where the noise is well
    determined, and not far where it is not.

    Parameters
    ----------
    covariance : (n_channels, n_channels) array
        Of the channels.
    n_lines : int
        Complex values of each that it is the mean of.

    References
    ----------
    Harman and Jones (1966), doi:10.1007/BF02289468 (minimum residuals).
    """
    scale = unexplained_scale(covariance)
    for least in LIKELIHOOD.common_power:
        scaled = covariance * np.outer(scale, scale)
        levels, directions = np.linalg.eigh(scaled)
        n_strong = _n_strong(levels, n_lines, least)
        if n_strong > _most_factors(len(scale)):
            break
        strong = directions[:, len(scale) - n_strong :]
        across = np.eye(len(scale)) - strong @ strong.T
        rest = np.einsum('ij,jk,ki->i', across, scaled, across)
        # With equal noise in all channels the diagonal is the share of it that lies across.
        variance = rest / np.maximum(np.diag(across), LIKELIHOOD.least_across)
        scale = scale / np.sqrt(np.maximum(variance, LIKELIHOOD.least_across))
    return scale


def _n_strong(levels: Real, n_lines: int, least: float) -> int:
    """Return how many eigenvalues, rising, stand out of those that so few lines make of noise.

    References
    ----------
    Marchenko and Pastur (1967), doi:10.1070/SM1967v001n04ABEH001994.
    """
    widened = least * (1.0 + np.sqrt(len(levels) / (2.0 * n_lines))) ** 2
    n_noise = len(levels) - _most_factors(len(levels))
    for _ in range(len(levels)):
        below = int(np.count_nonzero(levels <= widened * levels[:n_noise].mean()))
        if below <= n_noise:
            break
        n_noise = below
    return len(levels) - below


def _most_factors(n_channels: int) -> int:
    """Return how many common directions leave the noise of each channel determined (Ledermann)."""
    return int((2 * n_channels + 1 - np.sqrt(8 * n_channels + 1)) / 2) - 1
