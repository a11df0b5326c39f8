"""Mode shapes as few bytes: they are nine tenths of a result.

Entries of shapes have three digits (half precision, relative error below 2^-11), which is finer
than any window knows them.  Deviations have one byte each, on a logarithmic scale, right within
4 %: a standard deviation that was estimated from a window is not better known.
"""

import numpy as np
from numpy.typing import NDArray

LOWEST, HIGHEST = 1e-6, 10.0
"""Range of deviations beside 0, against the largest entry, which is 1."""
ZERO, UNKNOWN = 0, 255
STEPS = UNKNOWN - 2


def pack_shapes(shapes: NDArray[np.complex128]) -> bytes:
    """Return shapes as bytes; NaN where a point was not seen.

    Parameters
    ----------
    shapes : (n_channels, n_modes) complex array
        Largest entry of each 1.
    """
    return _parts(shapes).astype('<f2').tobytes()


def unpack_shapes(data: bytes, n_channels: int, n_modes: int) -> NDArray[np.complex128]:
    """Return shapes, (n_channels, n_modes).

    Raises
    ------
    ValueError
        Another number of bytes.
    """
    return _complex(np.frombuffer(data, '<f2').astype(float), n_channels, n_modes)


def pack_deviations(deviations: NDArray[np.complex128]) -> bytes:
    """Return deviations of real parts + i · those of imaginary parts as bytes; NaN: not known."""
    values = _parts(deviations)
    with np.errstate(divide='ignore', invalid='ignore'):
        steps = np.log(values / LOWEST) / np.log(HIGHEST / LOWEST) * STEPS
        codes = 1.0 + np.clip(np.rint(steps), 0, STEPS)
    codes = np.where(values == 0.0, ZERO, np.where(np.isnan(values), UNKNOWN, codes))
    return codes.astype(np.uint8).tobytes()


def unpack_deviations(data: bytes, n_channels: int, n_modes: int) -> NDArray[np.complex128]:
    """Return deviations, (n_channels, n_modes).

    Raises
    ------
    ValueError
        Another number of bytes.
    """
    codes = np.frombuffer(data, np.uint8)
    values = LOWEST * (HIGHEST / LOWEST) ** ((codes - 1.0) / STEPS)
    values = np.where(codes == ZERO, 0.0, np.where(codes == UNKNOWN, np.nan, values))
    return _complex(values, n_channels, n_modes)


def _parts(values: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return real and imaginary parts one after the other, mode by mode."""
    return np.ascontiguousarray(values.T).view(float).ravel()


def _complex(parts: NDArray[np.float64], n_channels: int, n_modes: int) -> NDArray[np.complex128]:
    pairs = parts.reshape(n_modes, n_channels, 2)
    return np.asarray((pairs[..., 0] + 1j * pairs[..., 1]).T)
