"""From a gradient on singular vectors to one on the covariances, in the frequency domain of lags.

A covariance stands in all blocks on one antidiagonal of the block Hankel matrix, so its gradient
is a sum over that antidiagonal.  Of a product of factors that sum is a convolution over the block
rows and columns: a product of their transforms, a tenth of the work of forming the gradient on
the matrix.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len

from oma_identifier.subspace.ssi_cov import back_substituted, HankelFactors

Real = NDArray[np.float64]
Single = NDArray[np.float32]
Complex = NDArray[np.complex128]
SingleComplex = NDArray[np.complex64]


class LagGradient:
    """Carries gradients over for one set of singular triplets.

    Single precision throughout: a standard deviation needs no more.

    Parameters
    ----------
    factors : HankelFactors
        With all singular vectors.  Roots are taken for known: to first order they change no pole
        of a model that holds.
    highest : int
        Highest model order.
    """

    def __init__(self, factors: HankelFactors, highest: int) -> None:
        left, values, right = factors.left, factors.values, factors.right
        n_outputs, n_references = factors.n_outputs, factors.n_references
        self._n_outputs, self._n_references = n_outputs, n_references
        self._block_rows = len(left) // n_outputs
        self._block_columns = len(right) // n_references
        self._n_lags = self._block_rows + self._block_columns - 1
        self._length = next_fast_len(self._n_lags, real=True)
        self._left = left.astype(np.float32)
        self._right = right.astype(np.float32)
        self._left_root = factors.left_root
        # The same vectors as they stand in a gradient on the matrix itself.
        self._left_back = self._of_matrix(self._left)
        self._right_back = self._right
        if factors.right_root is not None:
            self._right_back = back_substituted(factors.right_root, right).astype(np.float32)
        self._left_spectrum = self._transformed(self._left_back[:, :highest], self._block_rows)
        right_spectrum = self._transformed(self._right_back[:, :highest], self._block_columns)
        self._right_spectrum = np.ascontiguousarray(right_spectrum.transpose(0, 2, 1))
        # Of the difference of squares only what lies below the diagonal is ever used.
        gap = np.tril(values[:highest] ** 2 - values[:, None] ** 2, -1)
        inverse = np.divide(1.0, gap, out=np.zeros_like(gap), where=gap > 0.0)
        self._turns_left = (inverse * values[:highest]).astype(np.float32)[:, None]
        self._turns_right = (inverse * values[:, None]).astype(np.float32)[:, None]
        self._inverse_values = (1.0 / values[:highest]).astype(np.float32)

    def _of_matrix(self, vectors: Single) -> Single:
        if self._left_root is None:
            return vectors
        return back_substituted(self._left_root, vectors).astype(np.float32)

    def _transformed(self, vectors: Single, n_blocks: int) -> SingleComplex:
        """Return transforms over the blocks, (n_frequencies, size of a block, n_vectors)."""
        turn = _turns(n_blocks, self._length)
        blocks = vectors.reshape(n_blocks, -1)
        spectrum = np.empty((len(turn) // 2, blocks.shape[1]), dtype=np.complex64)
        both = turn @ blocks
        spectrum.real, spectrum.imag = both[: len(spectrum)], both[len(spectrum) :]
        return spectrum.reshape(len(spectrum), -1, vectors.shape[1])

    def of(self, rows: Complex, columns: Complex, orders: NDArray[np.int64]) -> SingleComplex:
        """Return gradients on the covariances.

        A change of H turns the leading vectors only towards the others:
        u_jᵀ du_k = (s_k u_jᵀ dH v_k + s_j u_kᵀ dH v_j) / (s_k² - s_j²).

        Parameters
        ----------
        rows, columns : (n_rows, n, n_gradients), (highest, n, n_gradients) complex array
            The gradient on the leading vectors of the observability is their product, rows times
            columns.
        orders : (n_gradients,) int array
            How many vectors lead.

        Returns
        -------
        (n_gradients, n_lags, n_outputs, n_references) complex array
            Gradients.
        """
        n_frequencies, n_gradients = self._length // 2 + 1, len(orders)
        n_outputs, n_references = self._n_outputs, self._n_references
        if self._left_root is not None:
            rows = times(self._left_root.T, rows.reshape(len(rows), -1)).reshape(rows.shape)
        flat = np.concatenate([rows.real, rows.imag], axis=1, dtype=np.float32)
        n_parts = flat.shape[1]
        flat = flat.reshape(len(flat), -1)
        projected = self._left.T @ flat
        outside = (flat - self._left @ projected).reshape(-1, n_parts, n_gradients)
        projected = projected.reshape(-1, n_parts, n_gradients)
        # A complex product as a real one, with real and imaginary parts side by side.
        parts = np.array([[columns.real, columns.imag], [-columns.imag, columns.real]])
        parts = parts.astype(np.float32).transpose(4, 0, 3, 1, 2)
        parts = parts.reshape(n_gradients, n_parts, 2, -1)
        shape = (n_gradients, n_frequencies, 2, n_outputs, n_references)
        spectrum = np.empty(shape, dtype=np.complex64)
        for number, order in enumerate(orders):
            part = np.ascontiguousarray(parts[number, :, :, :order])
            own = np.ascontiguousarray(projected[order:, :, number])
            mixed = (own @ part.reshape(n_parts, -1)).reshape(-1, 2, order)
            to_left = mixed * self._turns_left[order:, :, :order]
            to_right = mixed * self._turns_right[order:, :, :order]
            turned = self._left_back[:, order:] @ to_left.reshape(-1, 2 * order)
            part *= self._inverse_values[:order]
            turned += self._of_matrix(outside[:, :, number] @ part.reshape(n_parts, -1))
            first = self._transformed(turned, self._block_rows)
            turned = self._right_back[:, order:] @ to_right.reshape(-1, 2 * order)
            second = self._transformed(turned, self._block_columns)
            first = first.reshape(n_frequencies, 2 * n_outputs, order)
            second = second.reshape(n_frequencies, 2 * n_references, order).transpose(0, 2, 1)
            product = first @ self._right_spectrum[:, :order]
            other = self._left_spectrum[:, :, :order] @ second
            product = product.reshape(-1, n_outputs, 2, n_references).swapaxes(1, 2)
            other = other.reshape(-1, n_outputs, n_references, 2).transpose(0, 3, 1, 2)
            np.add(product, other, out=spectrum[number])
        lags = irfft(spectrum, self._length, axis=1)[:, : self._n_lags]
        return np.asarray(lags[:, :, 0] + 1j * lags[:, :, 1])


def _as_real(values: NDArray[Any]) -> NDArray[Any]:
    """Return real and imaginary parts side by side."""
    return np.concatenate([values.real, values.imag], axis=1)


def times(matrix: NDArray[Any], values: NDArray[Any]) -> NDArray[Any]:
    """Return a real matrix times complex columns, at the price of real ones."""
    both = matrix @ _as_real(values)
    half = values.shape[1]
    result = np.empty((len(both), half), dtype=values.dtype)
    result.real, result.imag = both[:, :half], both[:, half:]
    return result


@lru_cache(maxsize=16)
def _turns(n_blocks: int, length: int) -> Single:
    """Return the transform over blocks, cosines above minus sines."""
    phase = 2.0 * np.pi * np.outer(np.arange(length // 2 + 1), np.arange(n_blocks)) / length
    return np.concatenate([np.cos(phase), -np.sin(phase)]).astype(np.float32)
