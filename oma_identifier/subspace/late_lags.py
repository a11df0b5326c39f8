"""Whether the lags and orders of a Hankel matrix are enough for the modes that are there.

Of more modes than its orders hold with room to spare a factorisation makes fewer, broader ones,
and the data determine these well.  They describe the covariances they were made from, but not
those at later lags: a mixture of light modes beats, a broad mode only decays.

Of many modes those of such a mixture may decay before the later lags.  Then what an order with
room to spare leaves out stands above chance in the matrix itself; a window is asked that alone.

A robot's own motion is no sum of decays and is hardly foreseen at all: more lags and higher orders
would only give it more modes.
"""

import numpy as np

from oma_identifier.covariance import OutputCovariance
from oma_identifier.subspace.ssi_cov import factorise, HankelFactors, MultiOrder
from oma_identifier.subspace.thresholds import SUBSPACE


def lack_modes(covariance: OutputCovariance, block_rows: int, order: int) -> bool:
    """Tell whether covariances at later lags show modes that such a matrix has no room for.

    Parameters
    ----------
    covariance : OutputCovariance
        At more lags than ``2 * block_rows - 1``, in blocks.
    block_rows : int
        Of the block Hankel matrix of the first lags.
    order : int
        Highest model order; one with room to spare is asked.
    """
    if len(covariance.blocks) < 2:
        return False
    first = 2 * block_rows - 1
    mean, blocks = covariance.mean, covariance.blocks[:, first:]
    factors = factorise(mean[:first], block_rows)
    if leaves_more_than_chance(covariance.up_to(first), block_rows, order, factors):
        return True
    model = MultiOrder(factors, int(order / SUBSPACE.rows_per_order))
    kept, solution = model.highest, model.solve(model.highest)
    begin = factors.values[:kept] * factors.right[: factors.n_references, :kept]
    modal = np.linalg.lstsq(solution.vector, begin.T.astype(complex))[0]
    output = factors.left[: factors.n_outputs, :kept] @ solution.vector
    # What grows is noise of a light mode; it would drown all others at late lags.
    pole = solution.eigenvalue / np.maximum(1.0, np.abs(solution.eigenvalue))
    powers = pole ** np.arange(first, len(mean))[:, None]
    foreseen = ((output * powers[:, None, :]) @ modal).real
    # All as squares: what is not foreseen, what is there, and how much of both is chance.
    missed, there = np.sum((mean[first:] - foreseen) ** 2), np.sum(mean[first:] ** 2)
    chance = np.sum(blocks.var(axis=0, dtype=np.float64)) / (len(blocks) - 1)
    of_modes = missed < SUBSPACE.foreseen_less * there or there > SUBSPACE.rings_on * chance
    return bool(of_modes and missed > SUBSPACE.unforeseen * chance)


def leaves_more_than_chance(
    covariance: OutputCovariance,
    block_rows: int,
    order: int,
    factors: HankelFactors | None = None,
) -> bool:
    """Tell whether a singular value that an order with room to spare leaves out is above chance.

    The mean of the blocks with signs in turn has their scatter and nothing of what they share.

    Parameters
    ----------
    covariance : OutputCovariance
        At ``2 * block_rows - 1`` lags, in blocks.
    block_rows : int
        Of the block Hankel matrix.
    order : int
        Highest model order.
    factors : HankelFactors or None
        Of the mean of the blocks, where they are at hand.
    """
    blocks = covariance.blocks
    even = len(blocks) // 2 * 2
    if even == 0:
        return False
    values = (factors or factorise(covariance.mean, block_rows)).values
    kept = int(order / SUBSPACE.rows_per_order)
    first, second = (blocks[start:even:2].mean(axis=0, dtype=np.float64) for start in (0, 1))
    chance = factorise(0.5 * (first - second), block_rows).values
    last = min(len(values), len(chance))
    return bool(kept < last and values[kept] > SUBSPACE.left_out * chance[kept])
