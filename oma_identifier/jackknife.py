"""Standard deviations of poles without a formula: stretches of the record are left out in turn.

References
----------
Künsch (1989), doi:10.1214/aos/1176347265 (jackknife of blocks for dependent data), eq. 2.4.
"""

from collections.abc import Callable
from itertools import pairwise
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.indicators import mac
from oma_identifier.ssi_cov import RawPoles

N_BLOCKS = 20
LEAST_FOUND = 0.8
"""Share of the blocks without which a pole must be found again."""
FARTHEST = 4.0
"""Half-widths from the pole within which it is looked for."""


def jackknife(
    rows: NDArray[np.float64],
    solve: Callable[[NDArray[np.float64], int | None], RawPoles],
    pole: NDArray[np.complex128],
    shape: NDArray[np.complex128],
) -> NDArray[np.float64]:
    """Return the relative standard deviations of frequency and damping, (2, n_modes).

    Parameters
    ----------
    rows : (n_samples, n_columns) array
        The record.
    solve : callable
        Rows, and the row before which a stretch is missing, to poles at the model order that is
        wanted.  Windows over the gap would break the relation of known inputs to outputs by far
        more than the noise that the scatter is due to.
    pole : (n_modes,) complex array
        Natural logarithm of the eigenvalues whose scatter is asked for.
    shape : (n_channels, n_modes) complex array
        Their shapes.

    Returns
    -------
    (2, n_modes) array
        NaN for a pole that is not found again.
    """
    edges = np.linspace(0, len(rows), N_BLOCKS + 1).round().astype(int)
    found = np.full((N_BLOCKS, 2, len(pole)), np.nan)
    for block, (first, last) in enumerate(pairwise(edges)):
        raw = solve(np.concatenate([rows[:first], rows[last:]]), int(first) or None)
        found[block] = _again(raw, pole, shape)
    n_found = np.sum(np.isfinite(found[:, 0]), axis=0)
    enough = n_found >= max(LEAST_FOUND * N_BLOCKS, 2)
    result = np.full((2, len(pole)), math.nan)
    for mode in np.flatnonzero(enough):
        values = found[np.isfinite(found[:, 0, mode]), :, mode]
        factor = (len(values) - 1) ** 2 / len(values)
        result[:, mode] = np.sqrt(factor * values.var(axis=0, ddof=1)) / values.mean(axis=0)
    return result


def _again(
    raw: RawPoles, pole: NDArray[np.complex128], shape: NDArray[np.complex128]
) -> NDArray[np.float64]:
    """Return frequency and damping of the pole nearest to each, NaN where there is none."""
    values = np.full((2, len(pole)), np.nan)
    usable = np.isfinite(raw.eigenvalue) & (np.abs(raw.eigenvalue) > 0.0)
    if not usable.any():
        return values
    poles = np.log(raw.eigenvalue[usable])
    alike = mac(raw.shape[:, usable], shape)
    for mode, wanted in enumerate(pole):
        distance = np.abs(poles - wanted) / max(-wanted.real, 1e-12) + 2.0 * (1 - alike[:, mode])
        nearest = int(np.argmin(distance))
        if distance[nearest] < FARTHEST and poles[nearest].real < 0.0:
            size = abs(poles[nearest])
            values[:, mode] = size, -poles[nearest].real / size
    return values
