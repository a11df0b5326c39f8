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

from oma_identifier.likelihood.thresholds import LIKELIHOOD

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def _rotated(shapes: Complex) -> tuple[Complex, Complex]:
    """Return shapes turned so that their imaginary parts are least, and the factors used."""
    turn = np.exp(-0.5j * np.angle(np.sum(shapes * shapes, axis=0)))
    return np.asarray(shapes * turn), np.asarray(turn)


def _weight(shapes: Complex) -> float:
    """Return 1/σ² of one entry's imaginary part."""
    return max(len(shapes) - 1, 1) / LIKELIHOOD.complexity**2


def penalty(shapes: Complex) -> float:
    """Return the negative logarithm of the prior at shapes of unit length, one per column."""
    imaginary = 0.5 * (1.0 - np.abs(np.sum(shapes * shapes, axis=0)))
    return float(0.5 * _weight(shapes) * np.sum(imaginary))


def gradient(shapes: Complex, across: Complex) -> Real:
    """Return the downhill gradient over steps across each shape, (n_shapes, n_steps) array.

    Parameters
    ----------
    shapes : (n_channels, n_shapes) complex array
        Of unit length.
    across : (n_shapes, n_channels, n_channels - 1) complex array
        Directions of the steps; real and imaginary parts of each are parameters in turn.
    """
    at, turn = _rotated(shapes)
    slope = at.imag.T[:, None] @ _imaginary(turn[:, None, None] * across)
    return np.asarray(-_weight(shapes) * slope[:, 0])


def information(shapes: Complex, across: Complex) -> Real:
    """Return the information over the same steps, (n_shapes, n_steps, n_steps) array."""
    _, turn = _rotated(shapes)
    steps = _imaginary(turn[:, None, None] * across)
    return np.asarray(_weight(shapes) * (steps.swapaxes(1, 2) @ steps))


def _imaginary(across: Complex) -> Real:
    """Return the imaginary part of a step by each parameter."""
    return np.stack([across.imag, across.real], axis=-1).reshape(*across.shape[:2], -1)
