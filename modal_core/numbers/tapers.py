"""Tapers for spectra: sums of cosines, periodic."""

import numpy as np
from numpy.typing import NDArray

BLACKMAN_HARRIS = (0.35875, 0.48829, 0.14128, 0.01168)


def hann(length: int) -> NDArray[np.float64]:
    """Return the periodic Hann window, (length,) array."""
    return cosine_sum((0.5, 0.5), length)


def blackman_harris(length: int) -> NDArray[np.float64]:
    """Return the periodic window of four terms with side lobes below -92 dB, (length,) array.

    References
    ----------
    Harris (1978), doi:10.1109/PROC.1978.10837.
    """
    return cosine_sum(BLACKMAN_HARRIS, length)


def cosine_sum(weights: tuple[float, ...], length: int) -> NDArray[np.float64]:
    """Return Σ a_k cos(k φ), φ from -π on in ``length`` equal steps to just before π."""
    angle = np.linspace(-np.pi, np.pi, length + 1)
    taper = np.zeros(length + 1)
    for number, weight in enumerate(weights):
        taper += weight * np.cos(number * angle)
    return taper[:-1]
