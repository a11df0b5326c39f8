"""Gradient and Fisher information of the Whittle likelihood of one band.

With the covariance of a line E = L Lᴴ, both are inner products of whitened derivatives
L⁻¹ ∂E L⁻ᴴ: information Σ n tr(∂E ∂'E), gradient Σ n tr(∂E (P - E)), whitened all of them.  Nearly
every derivative is u vᴴ plus its conjugate transpose, and its c² independent real numbers are
formed line by line; the information is then one product of a matrix with its transpose.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

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
        # Only where modes are refined: the compiler behind it takes 100 MB.
        from oma_identifier.derivative_rows import fill_rows

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
            fill_rows(
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
