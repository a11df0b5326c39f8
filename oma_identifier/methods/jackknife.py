"""Standard deviations of poles without a formula: stretches of the record are left out in turn.

A stretch that holds the share h of what tells of a mode changes its pole, when it is left out, by
1 / (1 - h) times what its own noise does; the squares are weighted by 1 - h, which makes the sum
right for a linear estimate.  Where a mode responds evenly that is the plain jackknife of blocks.
Where a known input sweeps past it within a stretch or two nothing is left to estimate the mode
from, the estimate is far from linear, and the deviation too large: about right at 23 Hz, and 3
times (unknown forces a tenth of the known one) to 13 times (a fiftieth) at 9 Hz for one sweep
from 3 to 45 Hz in 30 s; 0.65 to 2.4 times for three sweeps of 10 s.

References
----------
Künsch (1989), doi:10.1214/aos/1176347265 (jackknife of blocks for dependent data), eq. 2.4;
Hinkley (1977), Jackknifing in unbalanced situations, Technometrics 19, 285-292.
"""

from itertools import pairwise
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import ifft, rfft

from modal_core.numbers.indicators import mac
from oma_identifier.methods.thresholds import METHOD
from oma_identifier.subspace import RawPoles

N_BLOCKS = 20


def stretches(n_rows: int) -> list[tuple[int, int]]:
    """Return first row and the one after the last of each stretch that is left out in turn."""
    edges = np.linspace(0, n_rows, N_BLOCKS + 1).round().astype(int)
    return [(int(first), int(last)) for first, last in pairwise(edges)]


def jackknife(
    responses: NDArray[np.float64],
    found: NDArray[np.complex128],
    pole: NDArray[np.complex128],
    shape: NDArray[np.complex128],
) -> NDArray[np.complex128]:
    """Return what each block of the record does to some poles.

    Parameters
    ----------
    responses : (n_samples, n_channels) array
        The record.
    found : (n_blocks, n_modes) complex array
        Each pole without one of the :func:`stretches`, NaN where it is not found again.  Windows
        over the gap would break the relation of known inputs to outputs by far more than the
        noise that the scatter is due to.
    pole : (n_modes,) complex array
        Natural logarithm of the eigenvalues whose scatter is asked for.
    shape : (n_channels, n_modes) complex array
        Their shapes.

    Returns
    -------
    (n_blocks, n_modes) complex array
        In units of ``pole``: the mean square of a column over the number of blocks is the
        variance of the pole.  NaN for a pole that is not found again.
    """
    n_found = np.sum(np.isfinite(found), axis=0)
    enough = n_found >= max(METHOD.least_found * N_BLOCKS, 2)
    left = 1.0 - _shares(responses, pole, shape)
    result = np.full((N_BLOCKS, len(pole)), np.nan, dtype=complex)
    for mode in np.flatnonzero(enough):
        known = np.isfinite(found[:, mode])
        values, weight = found[known, mode], left[known, mode]
        off = values - np.average(values, weights=weight)
        result[~known, mode] = 0.0
        result[known, mode] = -N_BLOCKS * np.sqrt(weight * N_BLOCKS / len(values)) * off
    return result


def _shares(
    responses: NDArray[np.float64], pole: NDArray[np.complex128], shape: NDArray[np.complex128]
) -> NDArray[np.float64]:
    """Return the share of each block in the response of each mode, (n_blocks, n_modes) array."""
    spectrum = rfft(responses, axis=0)
    line = 2.0 * np.pi / len(responses)
    shares = np.empty((N_BLOCKS, len(pole)))
    for mode, own in enumerate(pole):
        # Only lines near resonance count, of which few samples in time are enough.
        reach = METHOD.resonance_reach * abs(own.real)
        first = max(0, math.ceil((abs(own) - reach) / line))
        last = min(len(spectrum), max(math.ceil((abs(own) + reach) / line), first + 1))
        angle = line * np.arange(first, last)
        seen = spectrum[first:last] @ shape[:, mode].conj()
        seen /= 1.0 + ((angle - abs(own)) / own.real) ** METHOD.resonance_power
        n_samples = 2 * N_BLOCKS * math.ceil(len(seen) / N_BLOCKS)
        energy = np.abs(ifft(seen, n_samples)) ** 2
        shares[:, mode] = energy.reshape(N_BLOCKS, -1).sum(axis=1) / energy.sum()
    return shares


def found_again(
    raw: RawPoles,
    order: NDArray[np.int64],
    pole: NDArray[np.complex128],
    shape: NDArray[np.complex128],
) -> NDArray[np.complex128]:
    """Return the pole nearest to each, NaN where there is none."""
    values = np.full(len(pole), np.nan, dtype=complex)
    usable = np.isfinite(raw.eigenvalue) & (np.abs(raw.eigenvalue) > 0.0)
    if not usable.any():
        return values
    poles, of_order = np.log(raw.eigenvalue[usable]), raw.model_order[usable]
    alike = mac(raw.shape[:, usable], shape)
    for mode, wanted in enumerate(pole):
        distance = np.where(of_order == order[mode], 0.0, np.inf)
        distance += np.abs(poles - wanted) / max(-wanted.real, 1e-12) + 2.0 * (1 - alike[:, mode])
        nearest = int(np.argmin(distance))
        if distance[nearest] < METHOD.farthest and poles[nearest].real < 0.0:
            values[mode] = poles[nearest]
    return values
