"""Output covariances at positive lags, kept per block of time.

The sum over blocks is what subspace identification needs; the scatter over blocks is what the
uncertainty needs.  Blocks are added as samples arrive and either retired (a sliding window) or
joined in pairs (a whole record in bounded memory).  Lag 0 is left out: it holds the sensor noise.
"""

from collections import deque
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft


class WhenFull(Enum):
    """What happens to old blocks when there are more than the capacity."""

    RETIRE = 'retire'
    JOIN = 'join'


@dataclass(frozen=True)
class OutputCovariance:
    """Covariances of the outputs with the references.

    Parameters
    ----------
    blocks : (n_blocks, n_lags, n_channels, n_references) array [(m/s²)²]
        Covariance R_k = E[y(t) y_ref(t-k)ᵀ] of each block, lag k = row + 1, scaled so that their
        mean over the blocks is the covariance of the record.
    sample_rate_hz : float [Hz]
        One lag is one sample.
    n_samples : int
        Samples in all blocks together.
    """

    blocks: NDArray[np.float64]
    sample_rate_hz: float
    n_samples: int

    @cached_property
    def mean(self) -> NDArray[np.float64]:
        """Covariance of the record, (n_lags, n_channels, n_references)."""
        return np.asarray(self.blocks.mean(axis=0))

    @cached_property
    def single_blocks(self) -> NDArray[np.float32]:
        """Blocks as rows in single precision, (n_blocks, n_lags * n_channels * n_references)."""
        return self.blocks.reshape(len(self.blocks), -1).astype(np.float32)

    @property
    def duration_s(self) -> float:
        """Length of the record [s]."""
        return self.n_samples / self.sample_rate_hz


class CovarianceAccumulator:
    """Block sums of lagged products, updated once per sample.

    Parameters
    ----------
    n_lags : int
        Lags 1 .. n_lags.
    references : sequence of int
        Columns that serve as references.
    block_samples : int
        Samples per block at first.
    capacity : int
        Blocks kept.
    when_full : WhenFull
        Retire the oldest block, or join neighbours in pairs.
    """

    def __init__(
        self,
        n_lags: int,
        references: NDArray[np.int64],
        block_samples: int,
        capacity: int,
        when_full: WhenFull = WhenFull.JOIN,
    ) -> None:
        self.n_lags = n_lags
        self.references = references
        self.block_samples = block_samples
        self.capacity = capacity
        self.when_full = when_full
        self._blocks: deque[NDArray[np.float64]] = deque()
        self._powers: deque[NDArray[np.float64]] = deque()
        self._past: NDArray[np.float64] | None = None
        self._pending: list[NDArray[np.float64]] = []
        self._n_pending = 0

    def add(self, rows: NDArray[np.float64]) -> None:
        """Add the next samples, (n_samples, n_channels); complete blocks are summed at once."""
        if len(rows) == 0:
            return
        self._pending.append(rows)
        self._n_pending += len(rows)
        if self._n_pending < self.block_samples:
            return
        data = np.concatenate(self._pending)
        start = 0
        while len(data) - start >= self.block_samples:
            if self.when_full is WhenFull.JOIN and len(self._blocks) >= self.capacity:
                self._join()  # doubles the block length
                continue
            self._append(data[start : start + self.block_samples])
            start += self.block_samples
        self._keep(data[start:])

    def interrupt(self) -> None:
        """Forget what came just before: the next samples do not continue it."""
        self._past = None
        self._pending, self._n_pending = [], 0

    def _keep(self, rest: NDArray[np.float64]) -> None:
        self._pending = [rest.copy()] if len(rest) else []
        self._n_pending = len(rest)

    def _join(self) -> None:
        self._blocks = _in_pairs(self._blocks)
        self._powers = _in_pairs(self._powers)
        self.block_samples *= 2

    def _append(self, rows: NDArray[np.float64]) -> None:
        past = self._past
        if past is None:
            past = np.zeros((self.n_lags, rows.shape[1]))
        sums = lagged_products(rows, past, self.references)
        if self._past is None:
            # Nothing came before the first sample: fewer products at longer lags.
            lags = np.arange(1, self.n_lags + 1)
            counts = np.maximum(len(rows) - lags, 0.0)
            sums *= np.divide(len(rows), counts, out=np.zeros(len(lags)), where=counts > 0)[
                :, None, None
            ]
        self._past = np.concatenate([past, rows])[-self.n_lags :]
        self._blocks.append(sums)
        self._powers.append(np.sum(rows**2, axis=0))
        if self.when_full is WhenFull.RETIRE and len(self._blocks) > self.capacity:
            self._blocks.popleft()
            self._powers.popleft()

    @property
    def n_blocks(self) -> int:
        """Blocks there are now."""
        return len(self._blocks)

    @property
    def power(self) -> NDArray[np.float64]:
        """Mean square of each channel over the blocks kept, (n_channels,) array."""
        return np.asarray(np.mean(np.array(self._powers), axis=0) / self.block_samples)

    def result(self, sample_rate_hz: float) -> OutputCovariance:
        """Return the covariances of all blocks kept; one lag is one sample at this rate."""
        return OutputCovariance(
            blocks=np.array(self._blocks) / self.block_samples,
            sample_rate_hz=sample_rate_hz,
            n_samples=len(self._blocks) * self.block_samples,
        )


def _in_pairs(sums: deque[NDArray[np.float64]]) -> deque[NDArray[np.float64]]:
    blocks = list(sums)
    return deque(first + second for first, second in zip(blocks[::2], blocks[1::2], strict=True))


def lagged_products(
    rows: NDArray[np.float64], past: NDArray[np.float64], references: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return Σ_t y(t) y_ref(t-k)ᵀ for lags 1 .. n_lags.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        The block, t runs over its rows.
    past : (n_lags, n_channels) array
        Samples just before the block.
    references : (n_references,) int array
        Columns that serve as references.

    Returns
    -------
    (n_lags, n_channels, n_references) array
        Sums, exact: nothing wraps around.
    """
    n_lags, n_samples = len(past), len(rows)
    reference = np.concatenate([past, rows])[:, references]
    if len(references) * rows.shape[1] > 100:
        products = [
            rows.T @ reference[n_lags - lag : n_lags - lag + n_samples]
            for lag in range(1, n_lags + 1)
        ]
        return np.array(products)
    # y(t) y_ref(t-k): with the reference advanced by n_lags, a correlation at shift n_lags - k.
    n_fft = next_fast_len(n_samples + n_lags, real=True)
    outputs = rfft(rows, n_fft, axis=0)
    inputs = rfft(reference, n_fft, axis=0)
    cross = np.conj(outputs)[:, :, None] * inputs[:, None, :]
    shifts = np.asarray(irfft(cross, n_fft, axis=0))
    return np.asarray(shifts[n_lags - 1 :: -1][:n_lags])
