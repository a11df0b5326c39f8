"""Where the response ends at once, as at the end of a band of random forces.

A subspace method needs poles for such a fall, which the data determine well: they look like modes.
No structure falls as fast.  A resonance of half-width h has lost 1 + (d/h)² at a distance d; with
three blocks of lines before the fall and one block for it, what is left beyond is a ninth of the
least of the three at least, whatever the half-width and the size of the blocks.  What goes with
the fourth power of the frequency beside, as accelerations do below the lowest mode, adds little
to that where blocks are small against the frequency.
"""

import numpy as np
from numpy.typing import NDArray

from oma_identifier.spectra.thresholds import SPECTRA

Array = NDArray[np.float64]


def band_edges(power: Array) -> Array:
    """Return where a spectrum falls faster than a resonance can, and never comes back.

    Parameters
    ----------
    power : (n_lines,) array
        Summed over the channels, without leakage, the mean in the first line.

    Returns
    -------
    (n_edges,) array
        Lines, lower and upper ends.
    """
    last = len(power) - 1
    upper = [at for at, size in _falls(power) if size < SPECTRA.edge_share * at]
    lower = [
        last - at for at, size in _falls(power[::-1]) if size < SPECTRA.edge_share * (last - at)
    ]
    return np.sort(np.array([*lower, *upper]))


def _falls(power: Array) -> list[tuple[float, int]]:
    """Return the lines at which a spectrum falls for good, with the blocks that tell."""
    found: list[tuple[float, int]] = []
    smallest = _medians(power, SPECTRA.edge_block)
    n_joined = 1
    while len(blocks := _medians(smallest, n_joined)) * SPECTRA.edge_share > 1.0:
        size = SPECTRA.edge_block * n_joined
        n_joined *= 2
        before = np.min([blocks[:-4], blocks[1:-3], blocks[2:-2]], axis=0)
        beyond = np.maximum.accumulate(blocks[::-1])[::-1][4:]
        ratio = before / np.maximum(beyond, np.finfo(float).tiny)
        for first in _peaks_over(ratio, SPECTRA.edge_fall):
            level = np.sqrt(before[first] * beyond[first])
            part = power[(first + 2) * size : (first + 5) * size]
            at = (first + 2) * size + float(np.flatnonzero(part > level)[-1])
            if all(abs(at - other) > 4 * size for other, _ in found):
                found.append((at, size))
    return found


def _medians(values: Array, n_each: int) -> Array:
    """Return the medians of blocks; what is left over at the end is in none."""
    n_blocks = len(values) // n_each
    return np.asarray(np.median(values[: n_blocks * n_each].reshape(n_blocks, n_each), axis=1))


def _peaks_over(ratio: Array, least: float) -> list[int]:
    """Return where each run of ratios over a limit is largest."""
    over = np.concatenate([[False], ratio > least, [False]]).astype(int)
    edges = np.flatnonzero(np.diff(over)).reshape(-1, 2)
    return [int(first + np.argmax(ratio[first:last])) for first, last in edges]
