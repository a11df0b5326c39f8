"""Gradient and Fisher information of the Whittle likelihood of one band.

With the covariance of a line E = L Lᴴ, both are inner products of whitened derivatives
L⁻¹ ∂E L⁻ᴴ: information Σ n tr(∂E ∂'E), gradient Σ n tr(∂E (P - E)), whitened all of them.  Nearly
every derivative is u vᴴ plus its conjugate transpose, and its c² independent real numbers are
formed line by line; the information is then one product of a matrix with its transpose.
"""

from dataclasses import dataclass
from functools import cache
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.compiled import compiled

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
AT_ONCE = 50_000
"""Numbers of derivatives made at once: what a processor's cache holds."""


@dataclass(frozen=True, slots=True)
class Evaluated:
    """One model at all lines, as the derivatives need it.

    Parameters
    ----------
    count : (n_lines,) array
        Frequencies averaged in each line.
    amplitude : (n_lines, n_channels, n_modes) complex array
        A = Φ H.
    response : (n_lines, n_channels, n_modes) complex array
        A S.
    whitening : (n_lines, n_channels, n_channels) complex array
        L⁻¹, lower triangular.
    residual : (n_lines, n_channels, n_channels) complex array
        L⁻¹ (P - E) L⁻ᴴ.
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
    whitening: Complex
    residual: Complex
    gain: Complex
    by_frequency: Complex
    by_damping: Complex
    log_frequency: Real
    noise: Real
    across: Complex


@dataclass(frozen=True, slots=True)
class Derivatives:
    """Of the log-likelihood.

    Parameters of each free mode: ln f, ln ζ, then the shape along each direction across it (real
    and imaginary parts in turn); then the force (diagonal and upper triangle row by row, real
    parts, then the imaginary parts off the diagonal); then the slope; then ln s, one or one per
    channel.

    Parameters
    ----------
    gradient : (n_parameters,) array
        Σ n tr(E⁻¹ (P - E) E⁻¹ ∂E).
    information : (n_parameters, n_parameters) array
        Σ n tr(E⁻¹ ∂E E⁻¹ ∂'E).
    """

    gradient: Real
    information: Real

    @classmethod
    def of(cls, at: Evaluated, one_noise: bool) -> 'Derivatives':
        """Return those of one model."""
        n_lines, n_channels, n_modes = at.amplitude.shape
        n_noise = 1 if one_noise else n_channels
        count = len(at.across) * 2 * n_channels + n_modes**2 + 1 + n_noise
        gradient, information = np.zeros(count), np.zeros((count, count))
        at_once = min(n_lines, max(1, AT_ONCE // (count * n_channels**2)))
        # Residual first: it is one more row of the same matrix.
        rows = np.empty((1 + count, at_once, n_channels**2))
        for first in range(0, n_lines, at_once):
            part = slice(first, min(first + at_once, n_lines))
            rows[:, part.stop - first :] = 0.0
            _fill(
                rows,
                np.sqrt(at.count[part]),
                at.amplitude[part],
                at.response[part],
                at.whitening[part],
                at.residual[part],
                at.gain[part],
                at.by_frequency[part],
                at.by_damping[part],
                at.log_frequency[part],
                at.noise,
                at.across,
                one_noise,
            )
            flat = rows.reshape(1 + count, -1)
            information += flat[1:] @ flat[1:].T
            gradient += flat[1:] @ flat[0]
        return cls(gradient, information)


@cache
def pairs(n_modes: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns of the diagonal and upper triangle, row by row."""
    return np.triu_indices(n_modes)


@compiled
def _fill(
    rows: Real,
    weight: Real,
    amplitude: Complex,
    response: Complex,
    whitening: Complex,
    residual: Complex,
    gain: Complex,
    by_frequency: Complex,
    by_damping: Complex,
    log_frequency: Real,
    noise: Real,
    across: Complex,
    one_noise: bool,
) -> None:
    """Fill in the residual, then the derivative by each parameter, whitened and weighted."""
    n_lines, size, n_modes = amplitude.shape
    n_free = len(across)
    moved = np.empty((n_modes, size), dtype=np.complex128)
    answer = np.empty((n_modes, size), dtype=np.complex128)
    turned = np.empty(size, dtype=np.complex128)
    unit = np.empty(size, dtype=np.complex128)
    noisy = np.empty((size, size), dtype=np.complex128)
    for k in range(n_lines):
        white = whitening[k]
        scale = weight[k]
        _numbers(residual[k], scale, rows[0, k])
        for mode in range(n_modes):
            _times(white, amplitude[k, :, mode], moved[mode])
            _times(white, response[k, :, mode], answer[mode])
        row = 1
        for mode in range(n_free):
            _both(moved[mode], answer[mode], scale * by_frequency[k, mode], rows[row, k])
            _both(moved[mode], answer[mode], scale * by_damping[k, mode], rows[row + 1, k])
            row += 2
            for direction in range(size - 1):
                _times(white, across[mode, :, direction], turned)
                _both(turned, answer[mode], scale * gain[k, mode], rows[row, k])
                _both(turned, answer[mode], 1j * scale * gain[k, mode], rows[row + 1, k])
                row += 2
        imaginary = row + n_modes * (n_modes + 1) // 2
        for i in range(n_modes):
            for j in range(i, n_modes):
                share = 0.5 if i == j else 1.0
                _both(moved[i], moved[j], complex(share * scale), rows[row, k])
                row += 1
                if i < j:
                    _both(moved[i], moved[j], 1j * scale, rows[imaginary, k])
                    imaginary += 1
        row = imaginary
        for i in range(size):
            for j in range(size):
                noisy[i, j] = 0.0
                for n in range(min(i, j) + 1):
                    noisy[i, j] += noise[n] * white[i, n] * white[j, n].conjugate()
        if one_noise:
            _numbers(noisy, scale, rows[row + 1, k])
        else:
            for channel in range(size):
                unit[:] = white[:, channel]
                half = complex(0.5 * scale * noise[channel])
                _both(unit, unit, half, rows[row + 1 + channel, k])
        for i in range(size):
            for j in range(size):
                noisy[i, j] = (1.0 if i == j else 0.0) - noisy[i, j]
        _numbers(noisy, scale * log_frequency[k], rows[row, k])


@compiled
def _times(lower: Complex, vector: Complex, result: Complex) -> None:
    for i in range(len(result)):
        total = 0.0j
        for j in range(i + 1):
            total += lower[i, j] * vector[j]
        result[i] = total


@compiled
def _both(first: Complex, second: Complex, factor: complex, result: Real) -> None:
    """Write the numbers of w u vᴴ plus its conjugate transpose."""
    place = 0
    for i in range(len(first)):
        own, other = factor * first[i], factor.conjugate() * second[i]
        result[place] = 2.0 * (own * second[i].conjugate()).real
        place += 1
        for j in range(i + 1, len(first)):
            value = own * second[j].conjugate() + other * first[j].conjugate()
            result[place] = math.sqrt(2.0) * value.real
            result[place + 1] = math.sqrt(2.0) * value.imag
            place += 2


@compiled
def _numbers(matrix: Complex, factor: float, result: Real) -> None:
    """Write a Hermitian matrix as real numbers whose inner products are traces of products."""
    place = 0
    for i in range(len(matrix)):
        result[place] = factor * matrix[i, i].real
        place += 1
        for j in range(i + 1, len(matrix)):
            result[place] = factor * math.sqrt(2.0) * matrix[i, j].real
            result[place + 1] = factor * math.sqrt(2.0) * matrix[i, j].imag
            place += 2
