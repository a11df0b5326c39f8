"""Output covariances at positive lags, kept per block of time.

The sum over blocks is what subspace identification needs; the scatter over blocks is what the
uncertainty needs.  Blocks are added as samples arrive and either retired (a sliding window) or
joined in pairs (a whole record in bounded memory).  Lag 0 is left out: it holds the sensor noise.
"""

from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from oma_identifier.covariance.lagged_sums import lagged_sums


class WhenFull(Enum):
    """What happens to old blocks when there are more than the capacity."""

    RETIRE = 'retire'
    JOIN = 'join'


@dataclass(frozen=True)
class OutputCovariance:
    """Covariances of the outputs with the references.

    Parameters
    ----------
    blocks : (n_blocks, n_lags, n_channels, n_references) float32 array [(m/s²)²]
        Covariance R_k = E[y(t) y_ref(t-k)ᵀ] of each block, lag k = row + 1, scaled so that their
        mean over the blocks is the covariance of the record.
    sample_rate_hz : float [Hz]
        One lag is one sample.
    n_samples : int
        Samples in all blocks together.
    """

    blocks: NDArray[np.float32]
    sample_rate_hz: float
    n_samples: int

    @cached_property
    def mean(self) -> NDArray[np.float64]:
        """Covariance of the record, (n_lags, n_channels, n_references)."""
        return np.asarray(self.blocks.mean(axis=0, dtype=np.float64))

    @cached_property
    def single_blocks(self) -> NDArray[np.float32]:
        """Blocks as rows, (n_blocks, n_lags * n_channels * n_references)."""
        return self.blocks.reshape(len(self.blocks), -1).astype(np.float32, copy=False)

    @property
    def duration_s(self) -> float:
        """Length of the record [s]."""
        return self.n_samples / self.sample_rate_hz

    def up_to(self, n_lags: int) -> 'OutputCovariance':
        """Return the covariances at the first lags."""
        return replace(self, blocks=self.blocks[:, :n_lags])


class CovarianceAccumulator:
    """Block sums of lagged products, updated once per sample.

    A sample enters one sum, and the running total of all sums; what a solution costs does not
    depend on the number of samples.  Sums are kept in single precision (their estimation errors
    are larger by six decades), the total is exact for them.

    Parameters
    ----------
    n_lags : int
        Lags 1 .. n_lags.
    references : (n_references,) int array
        Columns that serve as references.
    block_samples : int
        Samples per block at first.
    capacity : int
        Blocks kept.
    when_full : WhenFull
        Retire the oldest block, or join neighbours in pairs.

    Attributes
    ----------
    n_added : int
        Blocks completed since the start.
    n_blocks : int
        Blocks there are now.
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
        # One array for all blocks: they would fragment the memory one by one.
        self._ring = np.empty((0, 0, n_lags, len(references)), np.float32)
        self._powers = np.empty((capacity, 0))
        self._at_once = np.zeros((capacity, len(references), len(references)))
        self._begun = np.zeros(capacity, dtype=np.int64)
        self._total = np.zeros((0, n_lags, len(references)))
        self._oldest = 0
        self.n_blocks = 0
        self._past: NDArray[np.floating] | None = None
        self._pending: list[NDArray[np.floating]] = []
        self._n_pending = 0
        self.n_added = 0

    def add(self, rows: NDArray[np.floating]) -> None:
        """Add the next samples, (n_samples, n_channels); complete blocks are summed at once."""
        if len(rows) == 0:
            return
        self._pending.append(rows)
        self._n_pending += len(rows)
        if self._n_pending < self.block_samples:
            return
        data = self._pending[0] if len(self._pending) == 1 else np.concatenate(self._pending)
        start = 0
        while len(data) - start >= self.block_samples:
            if self._is_full:
                self._join()  # doubles the block length
                continue
            self._append(data[start : start + self.block_samples])
            start += self.block_samples
        self._keep(data[start:])

    def interrupt(self) -> None:
        """Forget what came just before: the next samples do not continue it."""
        self._past = None
        self._pending, self._n_pending = [], 0

    @property
    def _is_full(self) -> bool:
        return self.when_full is WhenFull.JOIN and self.n_blocks >= self.capacity

    def _keep(self, rest: NDArray[np.floating]) -> None:
        self._pending = [rest.copy()] if len(rest) else []
        self._n_pending = len(rest)

    def _join(self) -> None:
        half = self.capacity // 2
        for place in range(half):
            self._ring[place] = self._ring[2 * place] + self._ring[2 * place + 1]
            self._powers[place] = self._powers[2 * place] + self._powers[2 * place + 1]
            self._at_once[place] = self._at_once[2 * place] + self._at_once[2 * place + 1]
            self._begun[place] = self._begun[2 * place] + self._begun[2 * place + 1]
        self.n_blocks = half
        self.block_samples *= 2

    def _append(self, rows: NDArray[np.floating]) -> None:
        begins, past = self._past is None, self._past
        if past is None:
            past = np.zeros((self.n_lags, rows.shape[1]), rows.dtype)
        sums = lagged_products(rows, past, self.references)
        self._past = np.concatenate([past, rows[-self.n_lags :]])[-self.n_lags :]
        # Channels first: combining them is one product of matrices.
        power = np.einsum('tc,tc->c', rows, rows, dtype=float)
        own = rows[:, self.references].astype(float)
        self._keep_block(sums.transpose(1, 0, 2), power, own.T @ own, begins)

    def _keep_block(
        self,
        sums: NDArray[np.floating],
        power: NDArray[np.float64],
        at_once: NDArray[np.float64],
        begins: bool,
    ) -> None:
        if self.n_added == 0:
            self._ring = np.empty((self.capacity, *sums.shape), np.float32)
            self._powers = np.empty((self.capacity, len(power)))
            self._total = np.zeros(sums.shape)
        self.n_added += 1
        if self.n_blocks == self.capacity:
            self._total -= self._ring[self._oldest]
            place, self._oldest = self._oldest, (self._oldest + 1) % self.capacity
        else:
            place = self.n_blocks
            self.n_blocks += 1
        self._ring[place], self._powers[place], self._begun[place] = sums, power, begins
        self._at_once[place] = at_once
        self._total += self._ring[place]

    @property
    def n_samples(self) -> int:
        """Samples in all blocks kept."""
        return self.n_blocks * self.block_samples

    @property
    def power(self) -> NDArray[np.float64]:
        """Mean square of each channel over the blocks kept, (n_channels,) array."""
        return np.asarray(np.mean(self._powers[: self.n_blocks], axis=0) / self.block_samples)

    @property
    def at_once(self) -> NDArray[np.float64]:
        """Covariance of the references at lag 0, their noise in it, n_references square."""
        return np.asarray(self._at_once[: self.n_blocks].mean(axis=0) / self.block_samples)

    @property
    def mean(self) -> NDArray[np.float64]:
        """Covariance over the blocks kept, (n_lags, n_channels, n_references); needs one block."""
        return np.asarray(self._total.transpose(1, 0, 2) / self._n_products[:, None, None])

    @property
    def _n_products(self) -> NDArray[np.float64]:
        """Products behind the sums of each lag, (n_lags,): a stretch begins with nothing before.

        Counted over all blocks: a blow just before the record is in its first block alone, and
        scaled by the products of that one its decay would seem slower than it is.
        """
        n_begun = int(self._begun[: self.n_blocks].sum())
        missing = n_begun * np.arange(1.0, self.n_lags + 1)
        return np.asarray(np.maximum(self.n_samples - missing, 1.0))

    def result(
        self,
        sample_rate_hz: float,
        outputs: NDArray[np.float64] | None = None,
        weight: NDArray[np.float64] | None = None,
    ) -> OutputCovariance:
        """Return the covariances of all blocks kept; one lag is one sample at this rate.

        Parameters
        ----------
        sample_rate_hz : float [Hz]
            Of the samples.
        outputs : (n_channels, n_outputs) array or None
            Combinations of channels to return instead of the channels.
        weight : (n_references,) array or None
            Factors of the references; None: 1.
        """
        n_channels, n_lags, n_references = self._total.shape
        combine = np.eye(n_channels) if outputs is None else outputs.T
        combine = (combine / self.block_samples).astype(np.float32)
        whole = (self.n_samples / self._n_products).astype(np.float32)
        blocks = np.empty((self.n_blocks, n_lags, len(combine), n_references), np.float32)
        for number in range(self.n_blocks):
            block = self._ring[(self._oldest + number) % self.capacity]
            combined = combine @ block.reshape(n_channels, -1)
            blocks[number] = combined.reshape(-1, n_lags, n_references).transpose(1, 0, 2)
        blocks *= whole[:, None, None]
        if weight is not None:
            blocks *= weight.astype(np.float32)
        return OutputCovariance(blocks, sample_rate_hz, self.n_samples)


def lagged_products(
    rows: NDArray[np.floating],
    past: NDArray[np.floating],
    references: NDArray[np.int64],
) -> NDArray[np.floating]:
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
    both = np.concatenate([past, rows])
    reference = both[:, references]
    # y(t) y_ref(t-k): the references, begun n_lags earlier, are n_lags - k ahead.
    return lagged_sums(reference, rows, len(past))[::-1].transpose(0, 2, 1)
