"""Whether the lags of a Hankel matrix are enough for the modes that are there.

Of more modes than its orders hold with room to spare a factorisation makes fewer, broader ones,
and the data determine these well.  They describe the covariances they were made from, but not
those at later lags: a mixture of light modes beats, a broad mode only decays.
"""

import numpy as np

from oma_identifier.covariance import OutputCovariance
from oma_identifier.subspace.ssi_cov import factorise, MultiOrder
from oma_identifier.subspace.thresholds import SUBSPACE


def are_foreseen(covariance: OutputCovariance, block_rows: int, order: int) -> bool:
    """Tell whether the poles of the first lags foresee the covariances at the later ones.

    Parameters
    ----------
    covariance : OutputCovariance
        At more lags than ``2 * block_rows - 1``, in blocks.
    block_rows : int
        Of the block Hankel matrix of the first lags.
    order : int
        Highest model order; one with room to spare is asked.
    """
    first = 2 * block_rows - 1
    mean, blocks = covariance.mean, covariance.blocks[:, first:]
    factors = factorise(mean[:first], block_rows)
    model = MultiOrder(factors, int(order / SUBSPACE.rows_per_order))
    kept, solution = model.highest, model.solve(model.highest)
    begin = factors.values[:kept] * factors.right[: factors.n_references, :kept]
    modal = np.linalg.lstsq(solution.vector, begin.T.astype(complex))[0]
    output = factors.left[: factors.n_outputs, :kept] @ solution.vector
    # What grows is noise of a light mode; it would drown all others at late lags.
    pole = solution.eigenvalue / np.maximum(1.0, np.abs(solution.eigenvalue))
    powers = pole ** np.arange(first, len(mean))[:, None]
    foreseen = ((output * powers[:, None, :]) @ modal).real
    left = np.sum((mean[first:] - foreseen) ** 2)
    scatter = np.sum(blocks.var(axis=0, dtype=np.float64))
    return not left * (len(blocks) - 1) > SUBSPACE.unforeseen * scatter
