"""Combined deterministic-stochastic subspace identification: part of the force is known.

The excitation is ours: the commanded joint motion shakes the arm.  What it explains no longer has
to be white, so that neither its spectrum nor its tones are mistaken for modes, while unmeasured
forces are still allowed for.

What leaving out stretches tells of its scatter (:mod:`oma_identifier.methods.jackknife`)
needs an input that keeps exciting every mode: for a single sweep past a mode its deviations are
too large.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from modal_core.errors import IdentificationError
from oma_identifier.covariance import HankelGram
from oma_identifier.subspace.ssi_cov import RawPoles
from oma_identifier.subspace.ssi_data import poles_of_projection, triangular_factor


def csi(
    rows: NDArray[np.float64],
    inputs: NDArray[np.float64],
    references: NDArray[np.int64],
    block_rows: int,
    orders: Sequence[int],
) -> RawPoles:
    """Return the poles of all model orders.

    The future outputs, freed of the future inputs, are projected on past inputs and outputs.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Conditioned responses.
    inputs : (n_samples, n_inputs) array
        Known inputs on the same grid, conditioned by the same filters: for a robot the joint
        accelerations.
    references : (n_references,) int array
        Outputs whose past is used.
    block_rows : int
        Block rows of future and of past.
    orders : sequence of int
        Model orders.

    Raises
    ------
    IdentificationError
        Inputs and responses differ in length, or an input does not move.

    References
    ----------
    Verhaegen (1994), doi:10.1016/0005-1098(94)90229-1 (PO-MOESP); Van Overschee and De Moor
    (1996), chapter 4; Reynders and De Roeck (2008), doi:10.1016/j.ymssp.2007.09.004 (reference-
    based combined identification).
    """
    gram = combined_gram(rows, inputs, block_rows)
    return combined_poles(gram, inputs.shape[1], references, block_rows, orders)


def combined_gram(
    rows: NDArray[np.float64], inputs: NDArray[np.float64], block_rows: int
) -> HankelGram:
    """Return all that :func:`combined_poles` needs of inputs and responses, see :func:`csi`."""
    _check(rows, inputs)
    both = np.concatenate([inputs / inputs.std(axis=0), rows], axis=1)
    return HankelGram(both, both, 2 * block_rows)


def combined_poles(
    gram: HankelGram,
    n_inputs: int,
    references: NDArray[np.int64],
    block_rows: int,
    orders: Sequence[int],
) -> RawPoles:
    """Return the poles of all model orders, see :func:`csi`."""
    size = gram.n_left
    whole = gram.gram(range(2 * block_rows)).reshape(2 * block_rows, size, 2 * block_rows, size)
    u, y = np.arange(n_inputs), np.arange(n_inputs, size)
    past, future = np.arange(block_rows), np.arange(block_rows, 2 * block_rows)
    y_past = n_inputs + np.asarray(references, dtype=np.intp)
    parts = [(future, u), (past, u), (past, y_past)]
    known = np.concatenate([_flat(times, of, size) for times, of in parts])
    wanted = _flat(future, y, size)
    matrix = whole.reshape(2 * block_rows * size, -1)
    triangle = triangular_factor(matrix[np.ix_(known, known)])
    factor = solve_triangular(
        triangle, matrix[np.ix_(wanted, known)].T, lower=True, check_finite=False
    ).T
    # The first columns belong to the future inputs; what is left is free of them.
    projection = factor[:, block_rows * n_inputs :]
    return poles_of_projection(projection, len(y), len(references) + n_inputs, orders)


def _flat(times: NDArray[np.int64], channels: NDArray[np.int64], size: int) -> NDArray[np.intp]:
    return np.asarray((times[:, None] * size + channels).ravel(), dtype=np.intp)


def _check(rows: NDArray[np.float64], inputs: NDArray[np.float64]) -> None:
    if len(rows) != len(inputs):
        raise IdentificationError(
            'inputs and responses differ in length', found=len(inputs), expected=len(rows)
        )
    still = np.flatnonzero(inputs.std(axis=0) == 0.0)
    if len(still):
        raise IdentificationError('an input does not move', where=f'input {still[0]}')
