"""Whitened derivatives of the covariances of a band as real numbers, line by line."""

import math

import numpy as np
from numpy.typing import NDArray

from modal_core.compiled import compiled

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@compiled
def fill_rows(
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
