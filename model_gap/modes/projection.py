"""What poles leave over of a response to a known motion, whatever its linear numbers are."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
import scipy.linalg

from model_gap.campaign import Complex, hann
from model_gap.modes.driven_response import DrivenResponse

Array = NDArray[np.float64]
# Of squares, relative.
ROUNDING = 1e-12


@dataclass(frozen=True)
class LeftOver:
    """What is left over at some poles, and all that was solved for.

    Parameters
    ----------
    residual : (n_rows, n_channels) array
        Real parts of all bins, then imaginary parts, over the noise.
    moved : (n_rows, n_numbers, n_channels) array
        What the numbers of the poles change with all that is linear held.
    basis, triangle : (n_rows, n_columns), (n_columns, n_columns) array
        QR of the columns of unit length; the last ones are those of the poles.
    solved : (n_columns, n_channels) array
        What each column is multiplied by.
    residues : (n_poles, n_forces, n_channels) complex array
        Of unit noise; the last force is that at the ends of the record.
    """

    residual: Array
    moved: Array
    basis: Array
    triangle: Array
    solved: Array
    residues: Complex

    @cached_property
    def _inside(self) -> Array:
        """What is linear makes up for of ``moved``, (n_columns, n_numbers n_channels)."""
        return np.asarray(self.basis.T @ self.moved.reshape(len(self.moved), -1))

    @property
    def jacobian(self) -> Array:
        """Derivatives of the residual by the numbers, (n_rows, n_channels, n_numbers)."""
        left = self.basis @ self._inside - self.moved.reshape(len(self.moved), -1)
        return left.reshape(self.moved.shape).transpose(0, 2, 1)

    @cached_property
    def reduced(self) -> tuple[Array, Array]:
        """Residual (n_numbers + 1,) and Jacobian with the products of the whole ones.

        No step of least squares depends on more of them than these.
        """
        n_numbers = self.moved.shape[1]
        whole, inside = (
            part.reshape(len(part), n_numbers, -1).transpose(0, 2, 1).reshape(-1, n_numbers)
            for part in (self.moved, self._inside)
        )
        slope = -whole.T @ self.residual.ravel()
        whole_gram = whole.T @ whole
        gram = whole_gram - inside.T @ inside
        # A pole that explains nothing moves nothing but rounding.
        moves = np.diag(gram) > ROUNDING * np.diag(whole_gram)
        size = np.sqrt(np.where(moves, np.diag(gram), 1.0))
        gram = np.where(np.outer(moves, moves), gram, 0.0) / np.outer(size, size)
        squares, axes = np.linalg.eigh(gram)
        seen = squares > ROUNDING
        scale = np.sqrt(np.where(seen, squares, 0.0))
        first = axes.T @ (slope / size) / np.where(seen, scale, np.inf)
        rest = float(np.sum(self.residual**2) - first @ first)
        return (
            np.append(first, np.sqrt(max(rest, 0.0))),
            np.vstack([scale[:, None] * axes.T * size, np.zeros((1, n_numbers))]),
        )


class Projection:
    """A response, less the best of all that is linear for some poles (variable projection).

    Parameters
    ----------
    record : DrivenResponse
        Response and motion.
    """

    def __init__(self, record: DrivenResponse) -> None:
        self.record = record
        size = np.sqrt(np.mean(record.noise_power, axis=1))
        weight = 1.0 / np.sqrt(np.mean(record.noise_power / size[:, None] ** 2, axis=0))
        self._weight = weight
        self.size = size
        self._response = _real((record.response / size[:, None] * weight).T)
        ends = np.ones((1, *record.omega.shape))
        self._force = np.concatenate([record.acceleration, ends])
        fixed = [hann(record.acceleration), hann(record.shift)]
        self._fixed = _real((np.concatenate(fixed) * weight).T)
        self._last: tuple[bytes, LeftOver] | None = None

    def columns(self, n_poles: int) -> int:
        """Return how many numbers each channel has beside some poles; 0 without any."""
        return self._fixed.shape[1] + 2 * len(self._force) * n_poles if n_poles else 0

    def at(self, numbers: Array) -> LeftOver:
        """Return the residual at some poles, once for residual and Jacobian."""
        key = numbers.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = key, self._solved(numbers)
        return self._last[1]

    def _solved(self, numbers: Array) -> LeftOver:
        poles, slopes = poles_of(numbers)
        n_force, n_fixed = len(self._force), self._fixed.shape[1]
        blocks = [self._fixed]
        for pole in poles:
            up, down = self._rung(pole, 1), self._rung(pole.conj(), 1)
            blocks += [_real(up + down), _real(1j * (up - down))]
        matrix = np.hstack(blocks)
        scale = np.linalg.norm(matrix, axis=0)
        basis, triangle = scipy.linalg.qr(matrix / scale, mode='economic', check_finite=False)
        ridge = 1e-10 * np.abs(np.diag(triangle)).max()
        triangle = triangle + ridge * np.eye(len(triangle))
        inside = basis.T @ self._response
        residual = self._response - basis @ inside
        solved = scipy.linalg.solve_triangular(triangle, inside)
        parts = (solved / scale[:, None])[n_fixed:].reshape(len(poles), 2, n_force, -1)
        residues = parts[:, 0] + 1j * parts[:, 1]
        ringing = [
            (self._rung(pole, 2) @ own, self._rung(pole.conj(), 2) @ own.conj())
            for pole, own in zip(poles, residues, strict=True)
        ]
        changes = [
            _real(slope * up + slope.conj() * down)
            for row in slopes
            for slope, (up, down) in zip(row, ringing, strict=True)
        ]
        moved = np.stack(changes, axis=1)
        return LeftOver(residual, moved, basis, triangle, solved, residues)

    def _rung(self, pole: complex, power: int) -> Complex:
        """Return what each force rings at a pole, (n_bins, n_forces)."""
        rung = self._force / (1j * self.record.omega - pole) ** power
        return np.asarray((hann(rung) * self._weight).T)


def numbers_of(poles: Complex) -> Array:
    """Return logarithms of frequencies [rad/s] and damping ratios."""
    size = np.abs(poles)
    return np.concatenate([np.log(size), np.log(np.maximum(-poles.real / size, 1e-4))])


def poles_of(numbers: Array) -> tuple[Complex, Complex]:
    """Return poles, and their derivatives by the logarithms, (2, n)."""
    omega, ratio = np.exp(numbers.reshape(2, -1))
    along = np.sqrt(1.0 - ratio**2)
    poles = omega * (-ratio + 1j * along)
    return poles, np.stack([poles, omega * ratio * (-1.0 - 1j * ratio / along)])


def _real(values: Complex) -> Array:
    return np.concatenate([values.real, values.imag])
