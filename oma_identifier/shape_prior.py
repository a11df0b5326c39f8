"""What is known of a mode shape beforehand: its entries are nearly in phase or out of phase.

Two modes that overlap wholly differ, for the data, by little but the distance of their poles:
almost any two complex mixtures of their shapes describe the record equally well.  A structure
whose damping is light vibrates in nearly real shapes, and saying so, weakly, halves what is open.
A shape that the data determine is not affected.

References
----------
Au, Brownjohn, Li, Raby (2021), Understanding and managing identification uncertainty of close
modes in operational modal analysis, doi:10.1016/j.ymssp.2020.107018 (real shapes throughout).
"""

import numpy as np
from numpy.typing import NDArray

COMPLEXITY = 0.25
"""Standard deviation of the imaginary part of a shape of unit length: MPC 0.78."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def _rotated(shape: Complex) -> tuple[Complex, complex]:
    """Return the shape turned so that its imaginary part is least, and the factor used."""
    square = np.sum(shape * shape)
    turn = np.exp(-0.5j * np.angle(square))
    return np.asarray(shape * turn), complex(turn)


def _weight(shape: Complex) -> float:
    """Return 1/σ² of one entry's imaginary part."""
    return max(len(shape) - 1, 1) / COMPLEXITY**2


def penalty(shape: Complex) -> float:
    """Return the negative logarithm of the prior at a shape of unit length."""
    imaginary = 0.5 * (1.0 - abs(np.sum(shape * shape)))
    return 0.5 * _weight(shape) * imaginary


def gradient(shape: Complex, across: Complex) -> Real:
    """Return the downhill gradient over steps across a shape.

    Parameters
    ----------
    shape : (n_channels,) complex array
        Of unit length.
    across : (n_channels, n_channels - 1) complex array
        Directions of the steps; real and imaginary parts of each are parameters in turn.
    """
    at, turn = _rotated(shape)
    return np.asarray(-_weight(shape) * (at.imag @ _imaginary(turn * across)))


def information(shape: Complex, across: Complex) -> Real:
    """Return the information over the same steps."""
    steps = _imaginary(_rotated(shape)[1] * across)
    return np.asarray(_weight(shape) * (steps.T @ steps))


def _imaginary(across: Complex) -> Real:
    """Return the imaginary part of a step by each parameter."""
    return np.stack([across.imag, across.real], axis=-1).reshape(len(across), -1)
