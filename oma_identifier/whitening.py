"""The covariance of each line of a band factored, and its data whitened by it."""

import math

import numpy as np
from numpy.typing import NDArray

from modal_core.compiled import compiled

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@compiled
def whitened(
    amplitude: Complex,
    force: Complex,
    noise: Real,
    periodogram: Complex,
    response: Complex,
    whitening: Complex,
    residual: Complex,
    log_determinant: Real,
) -> bool:
    """Fill in A S, L⁻¹, L⁻¹ (P - E) L⁻ᴴ and ln det E of all lines; False where E is no covariance.

    E = A S Aᴴ + diag s = L Lᴴ; the arrays are those of :class:`Evaluated`.
    """
    n_lines, size, n_modes = amplitude.shape
    lower = np.zeros((size, size), dtype=np.complex128)
    half = np.empty(size, dtype=np.complex128)
    for k in range(n_lines):
        for i in range(size):
            for n in range(n_modes):
                total = 0.0j
                for m in range(n_modes):
                    total += amplitude[k, i, m] * force[m, n]
                response[k, i, n] = total
        logarithm = 0.0
        for i in range(size):
            for j in range(i + 1):
                total = 0.0j
                for n in range(n_modes):
                    total += response[k, i, n] * amplitude[k, j, n].conjugate()
                if i == j:
                    total += noise[i]
                for n in range(j):
                    total -= lower[i, n] * lower[j, n].conjugate()
                if i > j:
                    lower[i, j] = total / lower[j, j].real
                    continue
                if not (total.real > 0.0 and math.isfinite(total.real)):
                    return False
                lower[i, i] = math.sqrt(total.real)
                logarithm += math.log(total.real)
        log_determinant[k] = logarithm
        for j in range(size):
            for i in range(size):
                if i < j:
                    whitening[k, i, j] = 0.0
                    continue
                total = 1.0 + 0.0j if i == j else 0.0j
                for n in range(j, i):
                    total -= lower[i, n] * whitening[k, n, j]
                whitening[k, i, j] = total / lower[i, i].real
        for i in range(size):
            for j in range(size):
                half[j] = 0.0
                for n in range(i + 1):
                    half[j] += whitening[k, i, n] * periodogram[k, n, j]
            for j in range(size):
                total = -1.0 + 0.0j if i == j else 0.0j
                for n in range(j + 1):
                    total += half[n] * whitening[k, j, n].conjugate()
                residual[k, i, j] = total
    return True
