"""Sinusoids of a stretch: those near known places, and those that a taper shows to be narrow."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft
from scipy.ndimage import maximum_filter1d, median_filter

from modal_core.numbers.tapers import blackman_harris
from oma_identifier.spectra.sinusoids import fit_sinusoids, Sinusoids
from oma_identifier.spectra.thresholds import SPECTRA

MOST_LINES = 32
SEARCHES = 4
BACKGROUND = 64
FAR_SIDE = 6
CLOSE_BY = 24
"""Spectral lines to both sides of a peak that tell the bell in which it is.  Chosen, not measured:
what is found is tested."""
COLUMNS_AT_ONCE = 4
"""A transform and its steps take several times what it is of."""

Real = NDArray[np.float64]


def power(rows: Real) -> NDArray[np.float32]:
    """Return the tapered periodogram of rows, (n_lines, n_channels), of noise as without."""
    taper = _taper(len(rows))[:, None]
    return _by_columns(lambda some: _periodogram(some * taper), rows)


@lru_cache(maxsize=2)
def _taper(length: int) -> Real:
    """Return the taper of mean square 1; windows and the record each want theirs many times."""
    taper = blackman_harris(length)
    taper /= np.sqrt(np.mean(taper**2))
    return taper


def power_cut_out(rows: Real) -> NDArray[np.float32]:
    """Return the periodogram of rows cut out as they are, (n_lines, n_channels).

    It is that of their steps, made up for: what moves slowly leaks into them as little as into
    samples that a high-pass filter has conditioned.
    """
    angle = np.pi * np.arange(len(rows) // 2 + 1) / len(rows)
    gain = np.where(angle > 0.0, 4.0 * np.sin(angle) ** 2, 1.0)

    def of(some: Real) -> Real:
        return _periodogram(np.diff(some, axis=0, append=some[-1:])) / gain[:, None]

    return _by_columns(of, rows)


def _by_columns(of: Callable[[Real], NDArray[Any]], rows: Real) -> NDArray[np.float32]:
    """Return the spectra of all columns, made of a few at a time."""
    spectra = np.empty((len(rows) // 2 + 1, rows.shape[1]), dtype=np.float32)
    for first in range(0, rows.shape[1], COLUMNS_AT_ONCE):
        columns = slice(first, first + COLUMNS_AT_ONCE)
        spectra[:, columns] = of(rows[:, columns])
    return spectra


def _periodogram(rows: Real) -> NDArray[np.float32]:
    spectrum = rfft(rows, axis=0)
    return np.asarray((spectrum.real**2 + spectrum.imag**2) / len(rows), dtype=np.float32)


def sinusoids_of(
    rows: Real, known: Real, kept: list[tuple[float, float]]
) -> tuple[Sinusoids, NDArray[np.float32]]:
    """Return the sinusoids in rows, near known places and elsewhere, and the power of the rest.

    What a taper shows to be narrow is looked for in what is left, again and again: strong lines
    hide weak ones.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Samples without offset.
    known : (n_known,) array
        Places of known lines in spectral lines, to less than one.
    kept : list of (first, last)
        Places where narrow peaks are no lines, in spectral lines.
    """
    to_turn = 2.0 * np.pi / len(rows)
    places, left, rest = known, rows, None
    fitted = Sinusoids(np.empty(0), np.empty((0, rows.shape[1]), dtype=complex))
    for search in range(SEARCHES):
        if search or not len(places):
            rest = power(left)
            more = narrow_peaks(rest, places, kept)[: MOST_LINES - len(places)]
            if not len(more):
                break
            places = np.concatenate([places, more])
        fitted = fit_sinusoids(rows, places * to_turn)
        places, rest = fitted.turn / to_turn, None
        left = np.asarray(fitted.taken_from(rows), dtype=np.float64)
    return fitted, power(left) if rest is None else rest


def narrow_peaks(
    each: NDArray[np.float32],
    known: Real | None = None,
    kept: Sequence[tuple[float, float]] = (),
) -> Real:
    """Return the places of narrow peaks in spectral lines, the strongest first.

    Parameters
    ----------
    each : (n_lines, n_channels) array
        Tapered periodogram.
    known, kept
        As for :func:`sinusoids_of`.
    """
    known = np.empty(0) if known is None else known
    n_whole = len(each) // BACKGROUND * BACKGROUND
    if n_whole < 2 * BACKGROUND:
        return np.empty(0)
    blocks = each[:n_whole].reshape(-1, BACKGROUND, each.shape[1])
    level = np.median(blocks, axis=1)
    level = np.minimum(level, np.minimum(np.roll(level, 1, axis=0), np.roll(level, -1, axis=0)))
    beyond = np.minimum(np.arange(len(each)) // BACKGROUND, len(level) - 1)
    ratio = each / np.maximum(level, np.finfo(np.float32).tiny)[beyond]
    best = ratio.max(axis=1)
    inner = slice(FAR_SIDE, len(each) - FAR_SIDE)
    sides = np.maximum(best[: -2 * FAR_SIDE], best[2 * FAR_SIDE :])
    peaks = best[inner] >= best[FAR_SIDE - 1 : -FAR_SIDE - 1]
    peaks &= best[inner] > best[FAR_SIDE + 1 : len(best) - FAR_SIDE + 1]
    peaks &= (best[inner] > SPECTRA.line_stands_out) & (sides < SPECTRA.line_fall * best[inner])
    found = FAR_SIDE + np.flatnonzero(peaks)
    found = found[np.argsort(-best[found])]
    new = [place for place in found if not _is_taken(float(place), known, kept)]
    return np.array(new, dtype=np.float64)


def peaks_over_their_bell(each: NDArray[np.float32]) -> Real:
    """Return the places of peaks over what is usual close by, the strongest first.

    A line within the bell of a mode stands out of it by too little to be narrow by its look alone,
    and bends the mode.  What such a peak is must be tested: it had not been asked in 2 of 50
    milled records (simulated), whose modes were up to 5 deviations off in damping.

    Parameters
    ----------
    each : (n_lines, n_channels) array
        Tapered periodogram.

    Returns
    -------
    (n_peaks,) array
        In spectral lines.
    """
    power = each.sum(axis=1, dtype=np.float64)
    usual = np.maximum(median_filter(power, 2 * CLOSE_BY + 1), np.finfo(np.float32).tiny)
    ratio = power / usual
    peaks = (ratio > SPECTRA.line_over_bell) & (power >= maximum_filter1d(power, 2 * FAR_SIDE + 1))
    found = FAR_SIDE + np.flatnonzero(peaks[FAR_SIDE : len(peaks) - FAR_SIDE])
    return found[np.argsort(-ratio[found])].astype(np.float64)


def _is_taken(place: float, known: Real, kept: Sequence[tuple[float, float]]) -> bool:
    near = bool(np.any(np.abs(known - place) < 1.0))
    return near or any(low - 2.0 <= place <= high + 2.0 for low, high in kept)
