"""One shape over all points from the shapes of set-ups that share some of them.

Each set-up sees the shape at its own points, in a scale of its own.  Shape and scales follow by
weighted least squares over all points; the covariance of both from the errors of each set-up.

References
----------
Au (2011), doi:10.1016/j.ymssp.2011.01.010 (global least squares); Döhler, Lam and Mevel (2013),
doi:10.1016/j.ymssp.2012.10.018 (uncertainty of merged shapes).
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.compare.thresholds import COMPARISON

MOST_ROUNDS = 50
"""Of least squares, shapes and scales in turn: of 400 random joins of 2 to 15 set-ups with one to
four references none moved by more than 1e-13 deviations in 1,950 rounds more."""

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class PartialShape:
    """A mode shape at some of the points.

    Parameters
    ----------
    rows : (n_channels,) int array
        Which points.
    shape : (n_channels,) complex array
        In any scale.
    variance : (n_channels,) array or None
        Of the complex entries, each for itself; None when not known.
    """

    rows: NDArray[np.intp]
    shape: Complex
    variance: Array | None


def own_variance(shape: Complex, std: Complex) -> Array:
    """Return the variance of each entry of a shape for itself, (n_channels,) array.

    Parameters
    ----------
    shape, std : (n_channels,) complex array
        As :class:`modal_core.mode.Mode` has them: the deviations hold the error of the largest
        entry, which is 1 by definition.  Sensors alike share it as if all had the same.
    """
    total, size = np.abs(std) ** 2, np.abs(shape / np.abs(shape).max()) ** 2
    own = total / (1.0 + size)
    largest = int(np.argmax(size))
    others = np.delete(own, largest)
    own[largest] = others.mean() if len(others) else 0.0
    return np.asarray(np.maximum(own, 1e-12 * max(own.max(), 1e-12)))


@dataclass(frozen=True, slots=True)
class JoinedShape:
    """A shape over all points.

    Parameters
    ----------
    shape : (n_points,) complex array
        Largest entry 1; NaN where nobody saw it.
    std : (n_points,) complex array or None
        Of real and imaginary parts; None when a set-up states none.
    mac_loss, mac_loss_std : float
        As :class:`modal_core.mode.Mode` has them.
    """

    shape: Complex
    std: Complex | None
    mac_loss: float
    mac_loss_std: float


def joined_shape(parts: Sequence[PartialShape], n_points: int) -> JoinedShape:
    """Join what the set-ups saw of one shape.

    Parameters
    ----------
    parts : sequence of PartialShape
        Each shares points with others.
    n_points : int
        Of all set-ups.
    """
    known = all(part.variance is not None for part in parts)
    parts = [part for part in parts if not known or _has_scale(part, parts)] or list(parts[:1])
    values = np.zeros((len(parts), n_points), dtype=complex)
    weight = np.zeros((len(parts), n_points))
    for k, part in enumerate(parts):
        size = np.abs(part.shape).max()
        values[k, part.rows] = part.shape / size
        weight[k, part.rows] = 1.0 if part.variance is None else size**2 / part.variance
    shape, scale = _fit(values, weight)
    seen = np.asarray((weight > 0.0).any(axis=0))
    largest = int(np.argmax(np.abs(shape)))
    scale, shape = scale * shape[largest], shape / shape[largest]
    shape[~seen] = complex(math.nan, math.nan)
    if not known:
        return JoinedShape(shape, None, math.nan, math.nan)
    covariance = _covariance(shape, scale, weight, seen, largest)
    covariance *= _excess(values, weight, shape, scale)
    return _with_errors(shape, covariance, seen)


def _has_scale(part: PartialShape, parts: Sequence[PartialShape]) -> bool:
    """Tell whether a part stands out at the points that it shares with others."""
    others = [other.rows for other in parts if other is not part]
    if not others:
        return True
    shared = np.isin(part.rows, np.concatenate(others))
    own = np.ones(len(part.shape)) if part.variance is None else part.variance
    return bool(np.sum(np.abs(part.shape[shared]) ** 2 / own[shared]) > COMPARISON.sure_scale**2)


def _fit(values: Complex, weight: Array) -> tuple[Complex, Complex]:
    """Return shape (n_points,) and scales (n_setups,): values ≈ scale · shape."""
    if len(values) == 1:
        return values[0], np.ones(1, dtype=complex)
    shared = (weight > 0.0).sum(axis=0) > 1
    everywhere = (weight > 0.0).all(axis=0)
    start = values[:, everywhere] * np.sqrt(weight[:, everywhere].mean(axis=0))
    left, _, _ = np.linalg.svd(start, full_matrices=False)
    scale = left[:, 0]
    held = weight * shared
    for _ in range(MOST_ROUNDS):
        shape = _regressed((weight * scale.conj()[:, None] * values).T, weight.T, scale)
        scale = _regressed(held * shape.conj() * values, held, shape)
        scale = scale / np.linalg.norm(scale)
    return _regressed((weight * scale.conj()[:, None] * values).T, weight.T, scale), scale


def _regressed(product: Complex, weight: Array, regressor: Complex) -> Complex:
    power = weight @ np.abs(regressor) ** 2
    return np.asarray(product.sum(axis=1) / np.where(power > 0.0, power, 1.0))


def _covariance(
    shape: Complex, scale: Complex, weight: Array, seen: NDArray[np.bool_], largest: int
) -> Complex:
    """Return the covariance of the shape, (n_points, n_points), 0 at its largest entry."""
    n_setups, n_points = weight.shape
    filled = np.where(seen, shape, 0.0)
    normal = np.zeros((n_points + n_setups, n_points + n_setups), dtype=complex)
    points, setups = np.arange(n_points), n_points + np.arange(n_setups)
    normal[points, points] = weight.T @ np.abs(scale) ** 2
    normal[setups, setups] = weight @ np.abs(filled) ** 2
    cross = weight.T * scale.conj() * filled[:, None]
    normal[:n_points, n_points:], normal[n_points:, :n_points] = cross, cross.conj().T
    free = np.concatenate([seen, np.ones(n_setups, dtype=bool)])
    free[largest] = False
    covariance = np.zeros_like(normal)
    covariance[np.ix_(free, free)] = np.linalg.pinv(normal[np.ix_(free, free)], hermitian=True)
    return np.asarray(covariance[:n_points, :n_points])


def _excess(values: Complex, weight: Array, shape: Complex, scale: Complex) -> float:
    """Return by how much set-ups differ beyond their errors (Birge's ratio, at least 1)."""
    shared = (weight > 0.0).sum(axis=0) > 1
    rest = values[:, shared] - scale[:, None] * shape[shared]
    free = int((weight[:, shared] > 0.0).sum()) - int(shared.sum()) - len(scale) + 1
    return max(1.0, float(np.sum(weight[:, shared] * np.abs(rest) ** 2)) / free) if free else 1.0


def _with_errors(shape: Complex, covariance: Complex, seen: NDArray[np.bool_]) -> JoinedShape:
    known = shape[seen]
    own = covariance[np.ix_(seen, seen)]
    square = np.vdot(known, known).real
    across = np.eye(len(known)) - np.outer(known, known.conj()) / square
    loss = across @ own @ across / square
    half = np.sqrt(0.5 * np.diag(covariance).real)
    std = np.where(seen, half + 1j * half, complex(math.nan, math.nan))
    return JoinedShape(shape, std, float(np.trace(loss).real), float(np.linalg.norm(loss)))
