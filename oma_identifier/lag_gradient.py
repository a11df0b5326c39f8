"""From a gradient on singular vectors to one on the covariances, in the frequency domain of lags.

A covariance stands in all blocks on one antidiagonal of the block Hankel matrix, so its gradient
is a sum over that antidiagonal.  Of a product of factors that sum is a convolution over the block
rows and columns: a product of their transforms, a tenth of the work of forming the gradient on
the matrix.
"""

from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len

Real = NDArray[np.float64]
Single = NDArray[np.float32]
Complex = NDArray[np.complex128]
SingleComplex = NDArray[np.complex64]


class LagGradient:
    """Carries gradients over for one set of singular triplets.

    Single precision throughout: a standard deviation needs no more.

    Parameters
    ----------
    left, right : (n_rows, n_kept), (n_columns, n_kept) array
        All singular vectors of the block Hankel matrix.
    values : (n_kept,) array
        Its singular values.
    n_outputs, n_references : int
        Size of one block.
    """

    def __init__(
        self, left: Real, values: Real, right: Real, n_outputs: int, n_references: int
    ) -> None:
        self._values = values
        self._n_outputs, self._n_references = n_outputs, n_references
        self._block_rows = len(left) // n_outputs
        self._block_columns = len(right) // n_references
        self._n_lags = self._block_rows + self._block_columns - 1
        self._length = next_fast_len(self._n_lags, real=True)
        self._left = left.astype(np.float32)
        self._right = right.astype(np.float32)

    @cached_property
    def _left_spectrum(self) -> SingleComplex:
        return self._transformed(self._left, self._block_rows)

    @cached_property
    def _right_spectrum(self) -> SingleComplex:
        return self._transformed(self._right, self._block_columns)

    def _transformed(self, vectors: Single, n_blocks: int) -> SingleComplex:
        """Return transforms over the blocks, (n_frequencies, size of a block, n_vectors)."""
        turn = _turns(n_blocks, self._length)
        blocks = vectors.reshape(n_blocks, -1)
        spectrum = np.empty((len(turn) // 2, blocks.shape[1]), dtype=np.complex64)
        both = turn @ blocks
        spectrum.real, spectrum.imag = both[: len(spectrum)], both[len(spectrum) :]
        return spectrum.reshape(len(spectrum), -1, vectors.shape[1])

    def __call__(self, rows: Complex, columns: Complex) -> SingleComplex:
        """Return the gradient on the covariances.

        A change of H turns the leading vectors only towards the others:
        u_jᵀ du_k = (s_k u_jᵀ dH v_k + s_j u_kᵀ dH v_j) / (s_k² - s_j²).

        Parameters
        ----------
        rows, columns : (n_rows, n), (order, n) complex array
            The gradient on the leading ``order`` left singular vectors is ``rows @ columns.T``.

        Returns
        -------
        (n_lags, n_outputs, n_references) complex array
            Gradient.
        """
        values, order = self._values, len(columns)
        rows, columns = rows.astype(np.complex64), columns.astype(np.complex64)
        projected = times(self._left.T, rows)
        outside = rows - times(self._left, projected)
        leading, rest = values[:order], values[order:, None]
        gap = (leading**2 - rest**2).astype(np.float32)
        leading, rest = leading.astype(np.float32), rest.astype(np.float32)
        mixed = (projected[order:] @ columns.T) / gap
        # Real and imaginary parts side by side: complex times real would double the work.
        turned_left = self._left[:, order:] @ _as_real(mixed * leading)
        turned_left += _as_real(outside @ (columns / leading[:, None]).T)
        turned_right = self._right[:, order:] @ _as_real(mixed * rest)
        first = self._transformed(turned_left, self._block_rows)
        second = self._transformed(turned_right, self._block_columns)
        n_outputs, n_references = self._n_outputs, self._n_references
        size = len(first)
        leading_right = self._right_spectrum[:, :, :order].transpose(0, 2, 1)
        product = first.reshape(size, 2 * n_outputs, order) @ leading_right
        product = product.reshape(size, n_outputs, 2, n_references)
        other = self._left_spectrum[:, :, :order] @ second.reshape(
            size, 2 * n_references, order
        ).transpose(0, 2, 1)
        product += other.reshape(size, n_outputs, n_references, 2).swapaxes(2, 3)
        lags = irfft(product, self._length, axis=0)[: self._n_lags]
        gradient = np.empty((self._n_lags, n_outputs, n_references), dtype=np.complex64)
        gradient.real, gradient.imag = lags[:, :, 0], lags[:, :, 1]
        return gradient


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
