"""Each sensor regressed on all others, in short blocks of a window, by samples about each moment.

What a sensor shows of a vibrating structure is a filtered sum of what the others show, whatever
the forces are.  The products of every block are made once; a fit to any blocks and sensors, and
what it leaves in each block, follow from them.

References
----------
Bendat and Piersol (2010), Random Data, 4th ed., section 7.3 (conditioned responses).
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples

MOST_COLUMNS = 96
"""Regressors: channels times samples of each.  With half as many the same 21 records with a loose
sensor (seeds 984000 to 984020) and 34 healthy ones (984100 to 984133) came out as well."""
MOST_LAGS = 8
"""Samples before a moment, and after it, at most.  Of the 21, 16 are told with 8 or 2; without
any 14, and one of a sensor that was heard."""
BLOCK_S, FEWEST_ROWS = 0.25, 48
MOST_BLOCKS = 500
"""Products kept, 40 MB at most; blocks of windows beyond two minutes are longer."""
USUAL = 0.4
"""Share of the blocks that tell what is usual: up to as many others may be of something else."""
SLOW = 4
"""Coefficients of the polynomial that is taken out of a block: motion of a robot, offsets.  With
one, 4 of the 34 healthy records have a suspected sensor instead of none."""
RIDGE = 1e-6
"""Share of the mean power; a hundred times more or less made no difference."""
ROUNDS = 5
"""Of fits that weigh blocks by what the last one left.  With one, 13 of the 21 are told, with two
or five 16."""
TINY = 1e-12
"""Of a channel's usual power in a block."""

Real = NDArray[np.float64]
Places = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Left:
    """What predictions of channels leave, block by block: (n_blocks, n_channels) arrays.

    Parameters
    ----------
    shown, said, common : array
        Power of what a channel shows, of its prediction, and of the products of both.
    """

    shown: Real
    said: Real
    common: Real

    @property
    def left(self) -> Real:
        """Power of the difference."""
        return np.maximum(self.shown - 2.0 * self.common + self.said, 0.0)

    @property
    def share(self) -> Real:
        """The same, of what is shown or said, whichever is more."""
        return np.asarray(self.left / (np.maximum(self.shown, self.said) + TINY))

    @property
    def coherence(self) -> Real:
        """Squared correlation of both."""
        return np.asarray(self.common**2 / ((self.shown + TINY) * (self.said + TINY)))

    @property
    def loudness(self) -> Real:
        """How loud a block is, of what is usual and at least 1: (n_blocks,), of most channels."""
        return np.asarray(np.median(np.maximum(1.0, self._own_loudness), axis=1))

    def surprise(self, loudness: Real) -> Real:
        """Return the power of the difference over what is usual in a block as loud.

        What is left of further modes grows with the forces, which all channels tell of.
        """
        loud = np.maximum(loudness[:, None], self._own_loudness)
        return np.asarray(self.left / (usual(self.left / loud) * loud + TINY))

    @property
    def _own_loudness(self) -> Real:
        return np.asarray(self.said / (usual(self.said) + TINY))


def usual(values: Real) -> Real:
    """Return what is usual over the blocks, the first axis."""
    place = int(USUAL * (len(values) - 1))
    return np.asarray(np.partition(values, place, axis=0)[place])


@dataclass(frozen=True, slots=True)
class Regressors:
    """Samples about a moment that a channel is regressed on.

    Parameters
    ----------
    channels : int array
        Of the samples.
    n_lags : int
        Samples before the moment, and after it.
    """

    channels: Places
    n_lags: int

    def about(self, samples: Samples, first: int, last: int) -> Real:
        """Return the samples about some moments, (n_moments, n_columns); lag by lag all channels.

        Moments are counted from the first that has all of them; the ends of a window go on as
        they are.
        """
        n_all = len(samples.acceleration)
        low, high = max(0, first), min(n_all, last + 2 * self.n_lags)
        rows = samples.acceleration[low:high][:, self.channels].astype(np.float64)
        outside = low - first, last + 2 * self.n_lags - high
        if any(outside):
            rows = np.pad(rows, (outside, (0, 0)), mode='edge')
        count = last - first
        return np.concatenate([rows[k : k + count] for k in range(2 * self.n_lags + 1)], axis=1)


class BlockRegression:
    """Products of all channels of a window with one another, block by block.

    Parameters
    ----------
    samples : Samples
        One window.
    channels : int array
        Of these.

    Attributes
    ----------
    regressors : Regressors
        What all are regressed on.
    scale, column_scale : (n_channels,), (n_columns,) array
        Usual size in a block of each channel, and of each sample that it is regressed on.
    """

    def __init__(self, samples: Samples, channels: Places) -> None:
        n = len(channels)
        self.channels = channels
        self.n_lags = int(np.clip((MOST_COLUMNS // n - 1) // 2, 0, MOST_LAGS))
        self.regressors = Regressors(channels, self.n_lags)
        n_all = len(samples.acceleration)
        shortest = max(FEWEST_ROWS, round(BLOCK_S * samples.sample_rate_hz))
        self.n_rows = max(shortest, math.ceil(n_all / MOST_BLOCKS))
        self.n_blocks = (n_all - 2 * self.n_lags) // self.n_rows
        n_columns = n * (2 * self.n_lags + 1)
        self._products = np.empty((max(self.n_blocks, 0), n_columns, n_columns))
        slow = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, self.n_rows), SLOW))[0]
        for block, products in enumerate(self._products):
            rows = self.regressors.about(samples, block * self.n_rows, (block + 1) * self.n_rows)
            rows -= slow @ (slow.T @ rows)
            np.matmul(rows.T, rows / self.n_rows, out=products)
        own = self._target(np.arange(n))
        size = np.sqrt(np.median(self._products[:, own, own], axis=0)) if self.n_blocks else own
        self.is_live = size > 0.0
        self.scale = np.where(self.is_live, size, 1.0)
        self.column_scale = np.tile(self.scale, 2 * self.n_lags + 1)
        self._products /= self.column_scale[:, None] * self.column_scale

    def weights(self, targets: Places, own: Sequence[Places], others: Places, use: Real) -> Real:
        """Return the fit of channels by others, (n_targets, n_columns).

        Parameters
        ----------
        targets : (n_targets,) int array
            Places among ``channels``.
        own : sequence of int arrays
            Of each sensor among the others: it is not predicted from itself.
        others : int array
            By which is fitted.
        use : (n_blocks,) array
            Weights of the blocks.
        """
        columns = self._columns(others)
        products = np.tensordot(use, self._products, 1)
        among = products[np.ix_(columns, columns)]
        among += RIDGE * np.trace(among) / max(len(columns), 1) * np.eye(len(columns))
        weights = np.zeros((len(targets), products.shape[0]))
        foreign = ~np.isin(targets, others)
        if foreign.any():
            across = products[np.ix_(columns, self._target(targets[foreign]))]
            weights[np.ix_(foreign, columns)] = np.linalg.solve(among, across).T
        if foreign.all():
            return weights
        inverse = np.linalg.inv(among)
        row_of = {place: row for row, place in enumerate(targets.tolist())}
        channel = columns % len(self.channels)
        for places in own:
            mine = np.flatnonzero((channel == places[:, None]).any(axis=0))
            if not len(mine):
                continue
            rows = -np.linalg.solve(inverse[np.ix_(mine, mine)], inverse[mine])
            rows[:, mine] = 0.0
            at = np.searchsorted(columns[mine], self._target(places))
            for place, row in zip(places.tolist(), rows[at], strict=True):
                if place in row_of:
                    weights[row_of[place], columns] = row
        return weights

    def left(self, weights: Real, targets: Places) -> Left:
        """Return what predictions leave of their channels."""
        at = self._target(targets)
        said = weights @ self._products
        return Left(
            self._products[:, at, at],
            np.einsum('bci,ci->bc', said, weights),
            said[:, np.arange(len(at)), at],
        )

    def robust(self, targets: Places, own: Sequence[Places], others: Places) -> tuple[Real, Left]:
        """Return a fit that few blocks of something else do not spoil, and what it leaves."""
        at = self._target(np.union1d(targets, others))
        calm = 1.0 / np.maximum(1.0, self._products[:, at, at].max(axis=1))
        use = calm
        for _ in range(ROUNDS):
            weights = self.weights(targets, own, others, use)
            left = self.left(weights, targets)
            excess = left.share / (usual(left.share) + TINY)
            use = calm / np.maximum(1.0, excess.max(axis=1)) ** 2
        return weights, left

    def _target(self, places: Places) -> Places:
        return np.asarray(self.n_lags * len(self.channels) + places)

    def _columns(self, places: Places) -> Places:
        lags = np.arange(2 * self.n_lags + 1)[:, None] * len(self.channels)
        return np.asarray((lags + np.sort(places)).ravel())
