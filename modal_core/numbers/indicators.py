"""Indicators of mode shapes: MAC, MPC, MPD, and the normalisation they share."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def mac(first: ArrayLike, second: ArrayLike) -> NDArray[np.float64]:
    """Return the modal assurance criterion between the columns of two sets of shapes.

    Parameters
    ----------
    first : (n_channels,) or (n_channels, n_first) complex array
        Mode shapes as columns.
    second : (n_channels,) or (n_channels, n_second) complex array
        Mode shapes as columns.

    Returns
    -------
    (n_first, n_second) array
        |φ₁ᴴφ₂|² / (φ₁ᴴφ₁ · φ₂ᴴφ₂), 0 where a shape is zero.

    References
    ----------
    Allemang and Brown (1982), A correlation coefficient for modal vector analysis, IMAC I.
    """
    a = np.asarray(first).reshape(len(np.asarray(first)), -1)
    b = np.asarray(second).reshape(len(np.asarray(second)), -1)
    scale = np.outer(_squared_norm(a), _squared_norm(b))
    product = np.abs(a.conj().T @ b) ** 2
    return _ratio(product, scale)


def mac_where_seen(
    first: NDArray[np.complex128], second: NDArray[np.complex128]
) -> NDArray[np.float64]:
    """Return the modal assurance criterion over the channels where neither shape is NaN.

    Parameters
    ----------
    first, second : (n_channels, n) complex array
        Mode shapes as columns, NaN where a mode was not seen; see :func:`mac`.

    Returns
    -------
    (n_first, n_second) array
        0 where there is no such channel.
    """
    a, b = np.nan_to_num(first), np.nan_to_num(second)
    of_a = (np.abs(a) ** 2).T @ np.isfinite(second)
    of_b = np.isfinite(first).T @ (np.abs(b) ** 2)
    return _ratio(np.abs(a.conj().T @ b) ** 2, of_a * of_b)


def mac_of_pairs(first: NDArray[Any], second: NDArray[Any]) -> NDArray[np.float64]:
    """Return the modal assurance criterion of each column with its counterpart, (n,) array.

    Parameters
    ----------
    first, second : (n_channels, n) array
        Mode shapes as columns; see :func:`mac`.
    """
    product = np.abs(np.einsum('cn,cn->n', first.conj(), second)) ** 2
    return _ratio(product, _squared_norm(first) * _squared_norm(second))


def mac_of_span(shape: NDArray[Any], shapes: NDArray[Any]) -> float:
    """Return the MAC of a shape with what is most like it of all that others sum up to.

    Parameters
    ----------
    shape : (n_channels,) array
        Not zero.
    shapes : (n_channels, n_shapes) array
        The others; none: 0.
    """
    basis = np.linalg.qr(shapes)[0]
    return float(np.linalg.norm(basis.conj().T @ shape) / np.linalg.norm(shape)) ** 2


def mpc(shapes: ArrayLike) -> NDArray[np.float64]:
    """Return the modal phase collinearity of each column: 1 for a real mode, 0 for a circle.

    Parameters
    ----------
    shapes : (n_channels, n_modes) complex array
        Mode shapes as columns.

    Returns
    -------
    (n_modes,) array
        ((S_xx - S_yy)² + 4 S_xy²) / (S_xx + S_yy)², without removing a mean: a shape over a few
        channels has no reason to average to zero.  NaN with one channel, which has one phase.

    References
    ----------
    Pappa, Elliott and Schenk (1993), doi:10.2514/3.11470; Vacher, Jacquier and Bucharles (2010).
    """
    columns = np.atleast_2d(np.asarray(shapes).T).T
    if len(columns) < 2:
        return np.full(columns.shape[1], np.nan)
    xx = np.sum(columns.real**2, axis=0)
    yy = np.sum(columns.imag**2, axis=0)
    xy = np.sum(columns.real * columns.imag, axis=0)
    return _ratio((xx - yy) ** 2 + 4.0 * xy**2, (xx + yy) ** 2)


def mpd(shapes: ArrayLike) -> NDArray[np.float64]:
    """Return the mean phase deviation of each column from its best straight line.

    Parameters
    ----------
    shapes : (n_channels, n_modes) complex array
        Mode shapes as columns.

    Returns
    -------
    (n_modes,) array [rad]
        Angle between each entry and the line, averaged with the entries' magnitudes as weights;
        0 for a real mode, at most π/2; NaN with one channel.

    References
    ----------
    Reynders, Houbrechts and De Roeck (2012), doi:10.1016/j.ymssp.2012.01.007, Eq. (9)-(12).
    """
    columns = np.atleast_2d(np.asarray(shapes).T).T
    if len(columns) < 2:
        return np.full(columns.shape[1], np.nan)
    magnitude = np.abs(columns)
    off_line = np.abs(rotate_to_real(columns).imag)
    angle = np.arcsin(np.clip(_ratio(off_line, magnitude), 0.0, 1.0))
    return _ratio(np.sum(magnitude * angle, axis=0), np.sum(magnitude, axis=0))


def rotate_to_real(shapes: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Turn each column so that its entries lie as close to the real axis as they can.

    Parameters
    ----------
    shapes : (n_channels, n_modes) complex array
        Mode shapes as columns.

    Returns
    -------
    (n_channels, n_modes) complex array
        Each column times a unit complex number (principal axis of its entries).
    """
    half_angle = 0.5 * np.angle(np.sum(shapes**2, axis=0))
    return np.asarray(shapes * np.exp(-1j * half_angle))


def normalise(shape: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Scale a shape so that its largest entry is 1 + 0i; a zero shape stays zero."""
    largest = shape[np.argmax(np.abs(shape))]
    return np.asarray(shape / largest) if largest != 0.0 else shape


def _squared_norm(columns: NDArray[np.complex128]) -> NDArray[np.float64]:
    return np.asarray(np.sum(np.abs(columns) ** 2, axis=0))


def _ratio(
    numerator: NDArray[np.float64], denominator: NDArray[np.float64]
) -> NDArray[np.float64]:
    ratio = np.zeros(np.shape(numerator))
    np.divide(numerator, denominator, out=ratio, where=denominator > 0.0)
    return ratio
