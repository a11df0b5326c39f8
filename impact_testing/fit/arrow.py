"""Normal equations whose unknowns mostly do not meet: an arrow of blocks.

A place that was not struck meets only the places that were, and the poles.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]


class Arrow:
    """A symmetric matrix of blocks, one slot of rows and columns per place and one for the poles.

    Parameters
    ----------
    n_slots, size : int
        Slots, and rows of each.
    apart : sequence of int
        Slots no two of which meet.
    """

    def __init__(self, n_slots: int, size: int, apart: Sequence[int]) -> None:
        self.size, self.n_slots = size, n_slots
        self.apart = np.array(sorted(apart), dtype=int)
        self.kept = np.setdiff1d(np.arange(n_slots), self.apart)
        self._row = np.zeros(n_slots, dtype=int)
        self._row[self.apart] = np.arange(len(self.apart))
        self._row[self.kept] = np.arange(len(self.kept))
        self._is_apart = np.isin(np.arange(n_slots), self.apart)
        self.own = np.zeros((len(self.apart), size, size))
        self.border = np.zeros((len(self.apart), size, len(self.kept), size))
        self.core = np.zeros((len(self.kept), size, len(self.kept), size))

    def add(self, first: int, second: int, block: Real) -> None:
        """Add a block, and its transpose on the other side: of a slot with itself, both."""
        i, j = self._row[first], self._row[second]
        if not self._is_apart[first] and not self._is_apart[second]:
            self.core[i, :, j] += block
            self.core[j, :, i] += block.T
        elif first == second:
            self.own[i] += block + block.T
        elif self._is_apart[first]:
            self.border[i, :, j] += block
        else:
            self.border[j, :, i] += block.T

    def diagonal(self) -> Real:
        """Return the diagonal, (n_slots, size) array."""
        found = np.zeros((self.n_slots, self.size))
        found[self.apart] = np.einsum('kii->ki', self.own)
        found[self.kept] = np.einsum('kiki->ki', self.core)
        return found

    def factored(self, scale: Real, lift: Real) -> 'Factored':
        """Factor it, scaled by rows and columns, with a diagonal added, (n_slots, size) arrays."""
        apart, kept, eye = scale[self.apart], scale[self.kept], np.eye(self.size)
        own = self.own * apart[:, :, None] * apart[:, None] + lift[self.apart][:, None] * eye
        border = self.border * apart[:, :, None, None] * kept
        core = self.core * kept[:, :, None, None] * kept
        flat = len(self.kept) * self.size
        core = core.reshape(flat, flat) + np.diag(lift[self.kept].ravel())
        border = border.reshape(len(self.apart), self.size, flat)
        inverse = np.linalg.inv(own)
        border = inverse @ border
        core = core - np.einsum('kif,kij,kjg->fg', border, own, border, optimize=True)
        return Factored(self, scale, inverse, border, np.linalg.inv(core))


@dataclass(frozen=True, slots=True)
class Factored:
    """Its inverse, by parts.

    Parameters
    ----------
    arrow : Arrow
    scale : (n_slots, size) array
    own : (n_apart, size, size) array
        Inverse blocks of the slots that do not meet.
    border : (n_apart, size, n_kept · size) array
        Those times what meets the others.
    core : (n_kept · size, n_kept · size) array
        Inverse of what the others have left.
    """

    arrow: Arrow
    scale: Real
    own: Real
    border: Real
    core: Real

    def solve(self, right: Real) -> Real:
        """Return the solutions of right sides, (n_slots, size, n) array."""
        arrow, count = self.arrow, right.shape[2]
        right = right * self.scale[:, :, None]
        first = right[arrow.apart]
        seen = right[arrow.kept].reshape(len(self.core), count)
        seen = seen - np.tensordot(self.border, first, axes=((0, 1), (0, 1)))
        kept = self.core @ seen
        found = np.zeros_like(right)
        found[arrow.kept] = kept.reshape(len(arrow.kept), arrow.size, count)
        found[arrow.apart] = self.own @ first - self.border @ kept
        return found * self.scale[:, :, None]

    def inverse_of(self, rows: slice) -> Real:
        """Return the inverse between the same rows of every slot.

        Returns
        -------
        (n_slots · n_rows, n_slots · n_rows) array
        """
        arrow = self.arrow
        n_rows, flat = len(range(*rows.indices(arrow.size))), len(self.core)
        turned = np.zeros((arrow.n_slots, n_rows, flat))
        turned[arrow.apart] = -self.border[:, rows]
        turned[arrow.kept] = np.eye(flat).reshape(-1, arrow.size, flat)[:, rows]
        rest = turned.reshape(-1, flat)
        found = (rest @ self.core @ rest.T).reshape(arrow.n_slots, n_rows, -1, n_rows)
        for row, slot in enumerate(arrow.apart):
            found[slot, :, slot] += self.own[row][rows, rows]
        size = self.scale[:, rows].ravel()
        return np.asarray(found.reshape(len(size), len(size)) * np.outer(size, size))


@dataclass(frozen=True, slots=True)
class Doubted:
    """The inverse of a factored matrix less what common unknowns explain: A - B M⁻¹ Bᵀ.

    Parameters
    ----------
    factored : Factored
        A.
    turned : (n_slots, size, n) array
        A⁻¹ B.
    core : (n, n) array
        Inverse of M - Bᵀ A⁻¹ B.

    References
    ----------
    Woodbury (1950), Inverting modified matrices, Princeton.
    """

    factored: Factored
    turned: Real
    core: Real

    @classmethod
    def of(cls, factored: Factored, columns: Real, inner: Real) -> 'Doubted':
        """Return it for B, (n_slots, size, n), and M."""
        turned = factored.solve(columns)
        left = inner - np.tensordot(columns, turned, axes=((0, 1), (0, 1)))
        return cls(factored, turned, np.asarray(np.linalg.inv(left), dtype=float))

    def solve(self, right: Real) -> Real:
        """Return the solution of a right side, (n_slots, size) array."""
        seen = np.einsum('sin,si->n', self.turned, right)
        return np.asarray(
            self.factored.solve(right[:, :, None])[:, :, 0] + self.turned @ (self.core @ seen)
        )

    def inverse_of(self, rows: slice) -> Real:
        """Return the inverse between the same rows of every slot."""
        part = self.turned[:, rows]
        part = part.reshape(part.shape[0] * part.shape[1], len(self.core))
        return np.asarray(self.factored.inverse_of(rows) + part @ self.core @ part.T)
