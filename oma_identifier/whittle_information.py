"""Gradient and Fisher information of the Whittle likelihood of one band.

Every derivative of the covariance E_k but those by noise and slope is w_k u_k v_kᴴ plus its
conjugate transpose, where u and v are columns of few matrices.  The information of two of them,
Σ n tr(E⁻¹ ∂E E⁻¹ ∂'E), is therefore a sum of products of entries of one small Gram matrix
C_k = Bᴴ E_k⁻¹ B, B = [A | A S | 1] with A = Φ H_k: no derivative is ever formed.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Evaluated:
    """One model at all lines, as the derivatives need it.

    Parameters
    ----------
    count : (n_lines,) array
        Frequencies averaged in each line.
    amplitude : (n_lines, n_channels, n_modes) complex array
        A = Φ H.
    response : (n_lines, n_channels, n_free) complex array
        Columns of A S that belong to free modes.
    precision : (n_lines, n_channels, n_channels) complex array
        E⁻¹.
    residual : (n_lines, n_channels, n_channels) complex array
        E⁻¹ (P - E) E⁻¹.
    excess : (n_lines,) array
        tr(E⁻¹ P) - n_channels.
    gain, by_frequency, by_damping : (n_lines, n_free) complex array
        H of the free modes, its derivatives by ln f and ln ζ over H.
    log_frequency : (n_lines,) array
        ln f from the reference: derivative of ln(A S Aᴴ) by the slope.
    noise : (n_channels,) array
        Noise power.
    across : (n_free, n_channels, n_channels - 1) complex array
        Directions across the shapes.
    """

    count: Real
    amplitude: Complex
    response: Complex
    precision: Complex
    residual: Complex
    excess: Real
    gain: Complex
    by_frequency: Complex
    by_damping: Complex
    log_frequency: Real
    noise: Real
    across: Complex


def gradient(at: Evaluated, one_noise: bool) -> Real:
    """Return Σ n tr(E⁻¹ (P - E) E⁻¹ ∂E) for every parameter.

    Parameters of each free mode: ln f, ln ζ, then the shape along each direction across it (real
    and imaginary parts in turn); then the force (diagonal and upper triangle row by row, real
    parts, then the imaginary parts off the diagonal); then the slope; then ln s, one or one per
    channel.
    """
    weighted = at.count[:, None, None] * at.residual
    n_modes, n_free = at.amplitude.shape[2], at.response.shape[2]
    pulled = weighted @ at.response
    own = np.sum(pulled.conj() * at.amplitude[:, :, :n_free], axis=1)
    poles = 2.0 * np.stack(
        [np.sum(at.by_frequency * own, axis=0).real, np.sum(at.by_damping * own, axis=0).real]
    )
    turning = np.einsum('km,kcm->mc', at.gain, pulled.conj())
    turned = 2.0 * (turning[:, None] @ at.across)[:, 0]
    shapes = np.stack([turned.real, -turned.imag], axis=-1).reshape(n_free, -1)
    modes = np.concatenate([poles.T, shapes], axis=1).ravel()
    flat = at.amplitude.reshape(-1, n_modes)
    force = flat.conj().T @ (weighted @ at.amplitude).reshape(-1, n_modes)
    first, second = np.triu_indices(n_modes)
    off = first != second
    upper = force[first, second] * np.where(off, 2.0, 1.0)
    on_diagonal = np.einsum('kcc->kc', weighted).real * at.noise
    # A S Aᴴ = E - diag s
    trace = at.count * at.excess - on_diagonal.sum(axis=1)
    noise = on_diagonal.sum(axis=0)
    return np.concatenate(
        [
            modes,
            upper.real,
            upper[off].imag,
            [float(at.log_frequency @ trace)],
            [noise.sum()] if one_noise else noise,
        ]
    )


@dataclass(frozen=True, slots=True)
class _Halves:
    """Derivatives w u vᴴ of the free modes before directions and real parts are taken.

    ``left`` and ``right`` index columns of B; ``weight`` is (n_halves, n_lines).
    """

    left: NDArray[np.intp]
    right: NDArray[np.intp]
    weight: Complex


def information(at: Evaluated, one_noise: bool) -> Real:
    """Return the Fisher information of the parameters of :func:`gradient`."""
    n_lines, n_channels, n_modes = at.amplitude.shape
    n_free = at.response.shape[2]
    unit = np.broadcast_to(np.eye(n_channels, dtype=complex), (n_lines, n_channels, n_channels))
    basis = np.concatenate([at.amplitude, at.response, unit], axis=2)
    gram = basis.conj().transpose(0, 2, 1) @ (at.precision @ basis)
    lines = np.ascontiguousarray(gram.transpose(1, 2, 0))
    halves = _free_halves(at, n_modes, n_free, n_channels)
    first, second = np.triu_indices(n_modes)
    to_modes, to_force = _mode_blocks(lines, halves, at.count, n_modes, first, second)
    force = _force_block(lines, at.count, n_modes, first, second)
    turn = _turn(at.across, n_channels)
    modes_modes = _real(*to_modes, turn, turn)
    modes_force = _with_pairs((turn.T @ to_force[0]), turn.T @ to_force[1], first != second)
    force_force = _pairs_with_pairs(*force, first != second)
    top = np.block([[modes_modes, modes_force], [modes_force.T, force_force]])
    rest = _slope_and_noise(lines, halves, at, turn, first, second, one_noise)
    return np.asarray(np.block([[top, rest[:, : len(top)].T], [rest]]))


def _free_halves(at: Evaluated, n_modes: int, n_free: int, n_channels: int) -> _Halves:
    left, right, weight = [], [], []
    for mode in range(n_free):
        left += [mode, mode, *range(n_modes + n_free, n_modes + n_free + n_channels)]
        right += [n_modes + mode] * (2 + n_channels)
        weight += [at.by_frequency[:, mode], at.by_damping[:, mode]]
        weight += [at.gain[:, mode]] * n_channels
    return _Halves(np.array(left), np.array(right), np.array(weight))


def _mode_blocks(
    lines: Complex,
    halves: _Halves,
    count: Real,
    n_modes: int,
    first: NDArray[np.intp],
    second: NDArray[np.intp],
) -> tuple[tuple[Complex, Complex], tuple[Complex, Complex]]:
    """Return the sums X and Y of the free modes with themselves and with the forces.

    X_ab = Σ n w_a w_b (v_aᴴ u_b)(v_bᴴ u_a), Y_ab = Σ n w_a w_b* (v_aᴴ v_b)(u_bᴴ u_a), inner
    products with E⁻¹.
    """
    left, right, weight = halves.left, halves.right, halves.weight
    weighted = weight * count
    x = lines[right[:, None], left] * (weighted[:, None] * weight) * lines[right, left[:, None]]
    y = lines[right[:, None], right] * (weighted[:, None] * weight.conj())
    y *= lines[left, left[:, None]]
    # u_b and v_b are columns i <= j of A: one product of matrices per row.
    from_right = weighted[:, None] * lines[right, :n_modes]
    into_left = lines[:n_modes, left].transpose(1, 2, 0)
    every = from_right @ into_left
    return (x.sum(axis=2), y.sum(axis=2)), (every[:, first, second], every[:, second, first])


def _force_block(
    lines: Complex,
    count: Real,
    n_modes: int,
    first: NDArray[np.intp],
    second: NDArray[np.intp],
) -> tuple[Complex, Complex]:
    inner = lines[:n_modes, :n_modes].reshape(n_modes**2, -1)
    # every[(p, q), (r, s)] = Σ n C_pq C_rs
    every = ((inner * count) @ inner.T).reshape((n_modes,) * 4)
    i, j = first[:, None], second[:, None]
    k, m = first[None], second[None]
    return every[j, k, m, i], every[j, m, k, i]


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
    lines: Complex,
    halves: _Halves,
    at: Evaluated,
    turn: Complex,
    first: NDArray[np.intp],
    second: NDArray[np.intp],
    one_noise: bool,
) -> Real:
    """Return the rows of slope and noise over all parameters."""
    n_channels = len(at.noise)
    units = np.arange(len(lines) - n_channels, len(lines))
    weight = np.concatenate([halves.weight, np.ones((len(first), len(at.count)))])
    left, right = np.concatenate([halves.left, first]), np.concatenate([halves.right, second])
    # Noise: E⁻¹ ∂E E⁻¹ on the diagonal; slope: E⁻¹ ∂E less that.
    power = at.noise[:, None, None]
    each = power * lines[units[:, None], left] * lines[right, units[:, None]] * weight
    noise = each @ at.count
    turning = at.count * at.log_frequency
    slope = (weight * lines[right, left] - each.sum(axis=0)) @ turning
    rows = np.concatenate([slope[None], noise])
    n_halves = len(halves.left)
    off = first != second
    modes = 2.0 * (rows[:, :n_halves] @ turn).real
    force = _of_pairs(rows[:, n_halves:], off)
    among = _among(lines[np.ix_(units, units)], at)
    whole = np.concatenate([modes, force, among], axis=1)
    if not one_noise:
        return whole
    whole = np.stack([whole[0], whole[1:].sum(axis=0)])
    return np.concatenate([whole[:, :-n_channels], whole[:, -n_channels:].sum(axis=1)[:, None]], 1)


def _of_pairs(rows: Complex, off: NDArray[np.bool_]) -> Real:
    real = rows.real * np.where(off, 2.0, 1.0)
    return np.concatenate([real, -2.0 * rows[:, off].imag], axis=1)


def _among(precision: Complex, at: Evaluated) -> Real:
    """Return the information of slope and noise with each other."""
    power = at.noise
    squares = np.abs(precision) ** 2 * np.outer(power, power)[:, :, None]
    noise = squares @ at.count
    diagonal = np.einsum('cck->ck', precision).real * power[:, None]
    turning = at.count * at.log_frequency
    cross = (diagonal - squares.sum(axis=1)) @ turning
    rest = len(power) - 2.0 * diagonal.sum(axis=0) + squares.sum(axis=(0, 1))
    own = rest @ (turning * at.log_frequency)
    return np.block([[np.array([[own]]), cross[None]], [cross[:, None], noise]])
