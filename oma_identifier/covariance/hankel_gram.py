"""Exact products of block Hankel matrices without ever forming one.

A data-driven subspace method needs the triangular factor of a block Hankel matrix whose rows are
as long as the record.  Its Gram matrix has the same information in a few hundred rows: block
(a, b) is Σ_t x(t+a) w(t+b)ᵀ, one lagged product per lag a - b plus the few samples in which the
windows of two blocks differ.  Memory is that of the record; nothing of size
block rows × channels × samples exists.
"""

from copy import copy

import numpy as np
from numpy.typing import NDArray

from oma_identifier.covariance.lagged_sums import lagged_sums


class HankelGram:
    """Products of the rows of block Hankel matrices of two series.

    Parameters
    ----------
    left : (n_samples, n_left) array
        Series x.
    right : (n_samples, n_right) array
        Series w.
    n_rows : int
        Row offsets a, b run from 0 to n_rows - 1; n_samples - n_rows + 1 columns each.

    Attributes
    ----------
    n_columns, n_left : int
        Columns of the block Hankel matrices; channels of the left series.
    """

    def __init__(self, left: NDArray[np.float64], right: NDArray[np.float64], n_rows: int) -> None:
        self.n_columns = len(left) - n_rows + 1
        self._left, self._right, self._n_rows = left, right, n_rows
        self.n_left, self._n_right = left.shape[1], right.shape[1]
        base = lagged_sums(left, right[: self.n_columns], n_rows)
        edge_left, edge_right = left[self.n_columns :], right[self.n_columns :]
        self._block = np.empty((n_rows, n_rows, self.n_left, self._n_right))
        for lag in range(n_rows):
            # Row b of this lag starts b samples later: what it loses there it gains at the end.
            count = n_rows - lag
            gained = np.einsum(
                'sl,sr->slr', edge_left[lag : lag + count - 1], edge_right[: count - 1]
            )
            lost = np.einsum('sl,sr->slr', left[lag : lag + count - 1], right[: count - 1])
            offsets = np.arange(count)
            self._block[offsets + lag, offsets] = base[lag]
            self._block[offsets[1:] + lag, offsets[1:]] += np.cumsum(gained - lost, axis=0)

    def without(self, left_out: tuple[int, int] | None) -> 'HankelGram':
        """Return the products without the windows that touch a stretch of the record.

        Parameters
        ----------
        left_out : (first, last) or None
            Samples of the stretch; None: there is none.
        """
        if left_out is None:
            return self
        reach = self._n_rows - 1
        touched = slice(max(0, left_out[0] - reach), left_out[1] + reach)
        own = HankelGram(self._left[touched], self._right[touched], self._n_rows)
        rest = copy(self)
        rest.n_columns = self.n_columns - own.n_columns
        rest._block = self._block - own._block
        return rest

    def product(
        self, left_rows: range, right_rows: range, of: NDArray[np.intp] | None = None
    ) -> NDArray[np.float64]:
        """Return H_x H_wᵀ for block rows a of the left and b of the right, a >= b everywhere.

        Parameters
        ----------
        left_rows, right_rows : range
            Offsets.
        of : (n,) int array or None
            Channels of the left series; None: all.
        """
        chosen = self._block[left_rows.start : left_rows.stop, right_rows.start : right_rows.stop]
        if of is not None:
            chosen = chosen[:, :, of]
        rows, columns, n_left, n_right = chosen.shape
        return np.asarray(chosen.transpose(0, 2, 1, 3).reshape(rows * n_left, columns * n_right))

    def gram(self, rows: range, of: NDArray[np.intp] | None = None) -> NDArray[np.float64]:
        """Return H_w H_wᵀ over these rows, where ``left[:, of]`` is the right series."""
        count = len(rows)
        lower = self._block[rows.start : rows.stop, rows.start : rows.stop]
        lower = lower if of is None else lower[:, :, of]
        full = lower.transpose(0, 2, 1, 3).copy()
        for a in range(count):
            for b in range(a + 1, count):
                full[a, :, b] = lower[b, a].T
        return np.asarray(full.reshape(count * self._n_right, count * self._n_right))
