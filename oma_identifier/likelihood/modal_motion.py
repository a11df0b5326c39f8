"""How the modes of a band moved, frequency by frequency, as its model and its data tell."""

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.band_model import BandData, BandModel, forced_gain

Complex = NDArray[np.complex128]


def expected_motion(data: BandData, model: BandModel, values: Complex) -> Complex:
    """Return the accelerations of all modes of a model to be expected given the data.

    Parameters
    ----------
    data, model : BandData and BandModel
        Of the band.
    values : (n_channels, n_lines) complex array
        Discrete Fourier transforms behind the averages, in the coordinates of the model.

    Returns
    -------
    (n_modes, n_lines) complex array
        H S Aᴴ E⁻¹ F in the notation of :mod:`oma_identifier.likelihood.whittle`.
    """
    gain = forced_gain(data, model)
    amplitude = model.shapes * gain[:, None, :]
    adjoint = model.force @ amplitude.conj().transpose(0, 2, 1)
    covariance = amplitude @ adjoint + np.diag(model.noise)
    best = gain[:, :, None] * (adjoint @ np.linalg.inv(covariance))
    return np.concatenate(
        [each @ block for each, block in zip(best, averaged_blocks(data, values), strict=True)],
        axis=1,
    )


def averaged_blocks(data: BandData, values: Complex) -> list[Complex]:
    """Return the values that belong to each average, each (n_channels, n_averaged)."""
    ends = np.cumsum(data.n_averaged.astype(int)).tolist()
    return [values[:, first:end] for first, end in zip([0, *ends], ends, strict=False)]
