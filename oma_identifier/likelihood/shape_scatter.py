"""Standard deviations of mode shapes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


def normalised_std(
    shape: NDArray[np.complex128], scatter: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Return the standard deviations of a shape whose largest entry is scaled to 1.

    Parameters
    ----------
    shape : (n_channels,) complex array
        In any scale.
    scatter : (n_channels, n_directions) complex array
        Its errors along independent directions, of one standard deviation each.

    Returns
    -------
    (n_channels,) complex array
        Standard deviation of the real part + i · that of the imaginary part; 0 at the largest
        entry, which is 1 by definition.
    """
    largest = int(np.argmax(np.abs(shape)))
    scaled = shape / shape[largest]
    change = (scatter - scaled[:, None] * scatter[largest]) / shape[largest]
    change[largest] = 0.0
    real, imaginary = (np.sqrt(np.sum(part**2, axis=1)) for part in (change.real, change.imag))
    return np.asarray(real + 1j * imaginary)


@dataclass(frozen=True, slots=True)
class MacLoss:
    """What chance takes from the MAC of an estimated shape with the true one.

    Parameters
    ----------
    mean, std : float
        To first order.
    """

    mean: float
    std: float

    @classmethod
    def of(cls, shape: NDArray[np.complex128], scatter: NDArray[np.complex128]) -> 'MacLoss':
        """Return mean and standard deviation of the squared length of the error across a shape.

        Parameters
        ----------
        shape : (n_channels,) complex array
            In any scale.
        scatter : (n_channels, n_directions) complex array
            Its errors along independent directions, of one standard deviation each.
        """
        square = np.vdot(shape, shape).real
        across = scatter - np.outer(shape, shape.conj() @ scatter) / square
        parts = np.concatenate([across.real, across.imag])
        covariance = parts @ parts.T / square
        return cls(float(np.trace(covariance)), float(np.sqrt(2.0 * np.sum(covariance**2))))
