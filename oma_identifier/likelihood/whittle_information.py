"""Fisher information of the Whittle likelihood of one band.

Every derivative of the covariance E_k but those by noise and slope is w_k u_k v_kᴴ plus its
conjugate transpose, where u and v are columns of few matrices.  The information of two of them,
Σ n tr(E⁻¹ ∂E E⁻¹ ∂'E), is therefore a sum of products of entries of one small Gram matrix
C_k = Bᴴ E_k⁻¹ B, B = [A | A S | 1] with A = Φ H_k: no derivative is ever formed.  Sums over the
lines are products of matrices wherever one factor depends on one half of the indices alone.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.whittle_gradient import Evaluated, pairs

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class _Products:
    """The blocks of C, lines last: inner products with E⁻¹ of A, of R = A S (free) and of 1.

    Parameters
    ----------
    among : (n_modes, n_modes, n_lines) complex array
        Aᴴ E⁻¹ A.
    right : (n_free, n_modes, n_lines) complex array
        Rᴴ E⁻¹ A.
    right_right : (n_free, n_free, n_lines) complex array
        Rᴴ E⁻¹ R.
    right_units : (n_free, n_channels, n_lines) complex array
        Rᴴ E⁻¹.
    units : (n_channels, n_modes, n_lines) complex array
        E⁻¹ A.
    precision : (n_channels, n_channels, n_lines) complex array
        E⁻¹.
    """

    among: Complex
    right: Complex
    right_right: Complex
    right_units: Complex
    units: Complex
    precision: Complex

    @classmethod
    def of(cls, at: Evaluated) -> '_Products':
        n_modes = at.amplitude.shape[2]
        columns = np.concatenate([at.amplitude, at.response], axis=2)
        onto = at.precision @ columns
        inner = (columns.conj().transpose(0, 2, 1) @ onto).transpose(1, 2, 0)
        onto = onto.transpose(1, 2, 0)
        blocks = (
            inner[:n_modes, :n_modes],
            inner[n_modes:, :n_modes],
            inner[n_modes:, n_modes:],
            onto[:, n_modes:].conj().transpose(1, 0, 2),
            onto[:, :n_modes],
            at.precision.transpose(1, 2, 0),
        )
        return cls(*(np.ascontiguousarray(block) for block in blocks))


def information(at: Evaluated) -> Real:
    """Return the Fisher information of the parameters of :func:`gradient`."""
    n_channels, n_modes = at.amplitude.shape[1:]
    products = _Products.of(at)
    # Derivatives w u vᴴ of each free mode: by its pole with u in A, by its shape with u in 1.
    poles = np.stack([at.by_frequency.T, at.by_damping.T], axis=1)
    gain = np.ascontiguousarray(at.gain.T)
    first, second = pairs(n_modes)
    off = first != second
    x, y = _modes_with_modes(products, poles, gain, at.count)
    to_force = _modes_with_force(products, poles, gain, at.count)
    turn = _turn(at.across, n_channels)
    modes_modes = _real(x, y, turn, turn)
    n_halves = len(turn)
    if at.root is None:
        modes_force = _with_pairs(
            turn.T @ to_force[:, first, second], turn.T @ to_force[:, second, first], off
        )
        force = _force_block(products.among, at.count, first, second)
        force_force = _pairs_with_pairs(*force, off)
        rows = _slope_and_noise(products, poles, gain, at, first, second)
        rows_force = _of_pairs(rows[:, n_halves:], off)
    else:
        x = (to_force @ at.root.conj()).reshape(n_halves, -1)
        y = (to_force.swapaxes(1, 2) @ at.root).reshape(n_halves, -1)
        modes_force = _to_parts(turn.T @ x, turn.T @ y)
        force_force = _of_parts(*_root_block(products.among, at.root, at.count))
        every = np.indices((n_modes, n_modes)).reshape(2, -1)
        rows = _slope_and_noise(products, poles, gain, at, *every)
        by_pair = rows[:, n_halves:].reshape(-1, n_modes, n_modes)
        by_root = (by_pair @ at.root.conj()).reshape(len(rows), -1)
        rows_force = _to_parts(by_root, np.zeros_like(by_root))
    top = _symmetric(modes_modes, modes_force, force_force)
    rest = [
        2.0 * (rows[:, :n_halves] @ turn).real,
        rows_force,
        _among(products.precision, at),
    ]
    below = np.concatenate(rest, axis=1)
    return _symmetric(top, below[:, : len(top)].T, below[:, len(top) :])


def _modes_with_modes(
    products: _Products, poles: Complex, gain: Complex, count: Real
) -> tuple[Complex, Complex]:
    """Return X_ab = Σ n w_a w_b (v_aᴴ u_b)(v_bᴴ u_a), Y_ab = Σ n w_a w_b* (v_aᴴ v_b)(u_bᴴ u_a).

    Inner products with E⁻¹.  All derivatives of one mode share v, so that two modes at a time are
    products of matrices.
    """
    n_free, n_lines = gain.shape
    n_channels = len(products.precision)
    size = 2 + n_channels
    met = np.empty((n_free, n_free, size, n_lines), dtype=complex)  # (v_aᴴ u_b) w_b
    met[:, :, :2] = products.right[:, :n_free, None] * poles
    met[:, :, 2:] = products.right_units[:, None] * gain[:, None]
    x = (met.swapaxes(0, 1) * count) @ met.swapaxes(2, 3)
    between = products.right_right * (count * gain.conj())
    y = np.empty((n_free, n_free, size, size), dtype=complex)
    shapes = (gain[:, None] * between).reshape(n_free**2, -1) @ (
        products.precision.reshape(-1, n_lines).T
    )
    y[:, :, 2:, 2:] = shapes.reshape(n_free, n_free, n_channels, -1).swapaxes(2, 3)
    towards = products.units[:, :n_free].transpose(1, 2, 0)
    mixed = (poles[:, None] * between[:, :, None]).reshape(n_free, -1, n_lines) @ towards
    mixed = mixed.reshape(n_free, n_free, 2, n_channels)
    y[:, :, :2, 2:] = mixed
    y[:, :, 2:, :2] = mixed.conj().transpose(1, 0, 3, 2)
    own = products.right_right * products.among[:n_free, :n_free].swapaxes(0, 1) * count
    y[:, :, :2, :2] = (poles[:, None] * own[:, :, None]) @ poles.conj().swapaxes(1, 2)
    n_halves = n_free * size
    return (
        np.asarray(x.swapaxes(1, 2).reshape(n_halves, n_halves)),
        np.asarray(y.swapaxes(1, 2).reshape(n_halves, n_halves)),
    )


def _modes_with_force(products: _Products, poles: Complex, gain: Complex, count: Real) -> Complex:
    """Return Σ n w_a (v_aᴴ a_i)(a_jᴴ u_a) for columns i and j of A."""
    n_free, n_modes, n_lines = products.right.shape
    n_channels = len(products.precision)
    result = np.empty((n_free, 2 + n_channels, n_modes, n_modes), dtype=complex)
    weighted = products.right * count
    own = products.among[:, :n_free].transpose(1, 2, 0)
    by_pole = (poles[:, :, None] * weighted[:, None]).reshape(n_free, -1, n_lines) @ own
    result[:, :2] = by_pole.reshape(n_free, 2, n_modes, n_modes)
    by_shape = (weighted * gain[:, None]).reshape(-1, n_lines) @ (
        products.units.reshape(-1, n_lines).conj().T
    )
    result[:, 2:] = by_shape.reshape(n_free, n_modes, n_channels, n_modes).swapaxes(1, 2)
    return result.reshape(-1, n_modes, n_modes)


def _force_block(
    among: Complex, count: Real, first: NDArray[np.intp], second: NDArray[np.intp]
) -> tuple[Complex, Complex]:
    n_modes = len(among)
    inner = among.reshape(n_modes**2, -1)
    # every[(p, q), (r, s)] = Σ n C_pq C_rs
    every = ((inner * count) @ inner.T).reshape((n_modes,) * 4)
    i, j = first[:, None], second[:, None]
    k, m = first[None], second[None]
    return every[j, k, m, i], every[j, m, k, i]


def _root_block(among: Complex, root: Complex, count: Real) -> tuple[Complex, Complex]:
    """Return X and Y of derivatives a_i (A L)_qᴴ by entries (i, q) of the root."""
    n_modes, n_forces = root.shape
    onto = np.tensordot(root.conj(), among, axes=(0, 0))  # (q, j): (A L)_qᴴ a_j
    both = np.tensordot(root, onto, axes=(0, 1)).swapaxes(0, 1)  # (q, s): (A L)_qᴴ (A L)_s
    flat = onto.reshape(n_forces * n_modes, -1)
    x = ((flat * count) @ flat.T).reshape(n_forces, n_modes, n_forces, n_modes)
    y = (both * count).reshape(n_forces**2, -1) @ among.reshape(n_modes**2, -1).T
    y = y.reshape(n_forces, n_forces, n_modes, n_modes)
    size = n_modes * n_forces
    return (
        np.asarray(x.transpose(3, 0, 1, 2).reshape(size, size)),
        np.asarray(y.transpose(3, 0, 2, 1).reshape(size, size)),
    )


def _turn(across: Complex, n_channels: int) -> Complex:
    """Return the combinations of halves that are the parameters of the free modes."""
    n_free = len(across)
    block, size = 2 + n_channels, 2 * n_channels
    matrix = np.zeros((n_free * block, n_free * size), dtype=complex)
    for mode in range(n_free):
        rows, columns = mode * block, mode * size
        matrix[rows, columns] = matrix[rows + 1, columns + 1] = 1.0
        matrix[rows + 2 : rows + block, columns + 2 : columns + size : 2] = across[mode]
        matrix[rows + 2 : rows + block, columns + 3 : columns + size : 2] = 1j * across[mode]
    return matrix


def _real(x: Complex, y: Complex, left: Complex, right: Complex) -> Real:
    """Return 2 Re(leftᵀ X right + leftᵀ Y right*)."""
    return np.asarray(2.0 * (left.T @ (x @ right + y @ right.conj())).real)


def _to_parts(x: Complex, y: Complex) -> Real:
    """Return 2 Re(X right + Y right*), of the real and imaginary parts of entries in turn.

    The same as :func:`_real` with right = I ⊗ [1, i], which is all zeros but for these.
    """
    return _in_turn(2.0 * (x + y).real, 2.0 * (y - x).imag)


def _of_parts(x: Complex, y: Complex) -> Real:
    """Return the same of both sides."""
    real = _to_parts(x, y)
    imaginary = _in_turn(-2.0 * (x + y).imag, 2.0 * (y - x).real)
    return _in_turn(real.T, imaginary.T).T


def _in_turn(first: Real, second: Real) -> Real:
    """Return columns of two matrices, one of each in turn."""
    return np.stack([first, second], axis=2).reshape(len(first), -1)


def _with_pairs(x: Complex, y: Complex, off: NDArray[np.bool_]) -> Real:
    """Return the same for columns a_i a_jᴴ: real parts (half on the diagonal), then imaginary."""
    half = np.where(off, 2.0, 1.0)
    real = (x + y).real * half
    imaginary = 2.0 * (y - x)[:, off].imag
    return np.concatenate([real, imaginary], axis=1)


def _pairs_with_pairs(x: Complex, y: Complex, off: NDArray[np.bool_]) -> Real:
    half = np.where(off, 1.0, 0.5)[:, None]
    above = _with_pairs(x * half, y * half, off)
    below = _with_pairs(1j * x[off], 1j * y[off], off)
    return np.concatenate([above, below])


def _slope_and_noise(
    products: _Products,
    poles: Complex,
    gain: Complex,
    at: Evaluated,
    first: NDArray[np.intp],
    second: NDArray[np.intp],
) -> Complex:
    """Return the rows of slope, curvature and noise over what makes up modes and forces."""
    n_free, n_modes, n_lines = products.right.shape
    n_channels = len(at.noise)
    turning = at.count * at.colours
    weights = np.concatenate([at.count[None], turning])
    # Noise: E⁻¹ ∂E E⁻¹ on the diagonal; slope and curvature: E⁻¹ ∂E less that.
    halves = np.empty((n_channels, n_free, 2 + n_channels, len(weights)), dtype=complex)
    into = products.right_units.swapaxes(0, 1)  # channels first
    by_pole = (products.units[:, :n_free] * into)[:, :, None] * poles
    halves[:, :, :2] = by_pole @ weights.T
    by_shape = (into * gain)[:, :, None] * weights
    by_shape = products.precision @ by_shape.reshape(n_channels, -1, n_lines).swapaxes(1, 2)
    by_shape = by_shape.reshape(n_channels, n_channels, n_free, len(weights))
    halves[:, :, 2:] = by_shape.swapaxes(1, 2)
    weighted = (products.units[:, None] * weights[:, None]).reshape(n_channels, -1, n_lines)
    pairs = weighted @ products.units.conj().swapaxes(1, 2)
    pairs = pairs.reshape(n_channels, -1, n_modes, n_modes)[:, :, first, second].swapaxes(1, 2)
    every = np.concatenate([halves.reshape(n_channels, -1, len(weights)), pairs], axis=1)
    every *= at.noise[:, None, None]
    slope = np.empty((n_free, 2 + n_channels, len(turning)), dtype=complex)
    slope[:, :2] = (poles * products.right[range(n_free), range(n_free), None]) @ turning.T
    slope[:, 2:] = (products.right_units * gain[:, None]) @ turning.T
    on_modes = slope.reshape(-1, len(turning))
    whole = np.concatenate([on_modes, products.among[second, first] @ turning.T])
    return np.concatenate([(whole - every[:, :, 1:].sum(axis=0)).T, every[:, :, 0]])


def _symmetric(first: Real, mixed: Real, second: Real) -> Real:
    """Return a symmetric matrix of its blocks: np.block takes longer than what it joins."""
    count = len(first)
    whole = np.empty((count + len(second), count + len(second)))
    whole[:count, :count], whole[:count, count:] = first, mixed
    whole[count:, :count], whole[count:, count:] = mixed.T, second
    return whole


def _of_pairs(rows: Complex, off: NDArray[np.bool_]) -> Real:
    real = rows.real * np.where(off, 2.0, 1.0)
    return np.concatenate([real, -2.0 * rows[:, off].imag], axis=1)


def _among(precision: Complex, at: Evaluated) -> Real:
    """Return the information of slope, curvature and noise with each other."""
    power = at.noise
    squares = np.abs(precision) ** 2 * np.outer(power, power)[:, :, None]
    noise = squares @ at.count
    diagonal = np.einsum('cck->ck', precision).real * power[:, None]
    turning = at.count * at.colours
    cross = turning @ (diagonal - squares.sum(axis=1)).T
    rest = len(power) - 2.0 * diagonal.sum(axis=0) + squares.sum(axis=(0, 1))
    own = (rest * turning) @ at.colours.T
    return _symmetric(own, cross, noise)
