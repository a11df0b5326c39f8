"""Peaks of a curve that rise above the valleys to both sides."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Prominent:
    """Peaks of a curve.

    Parameters
    ----------
    place : (n_peaks,) int array
        Rising; the middle of a flat top.
    prominence : (n_peaks,) array
        Height above the higher one of the lowest points to both sides, each before the curve rises
        above the peak.
    left, right : (n_peaks,) int array
        Those lowest points, the nearest of equal ones.
    """

    place: NDArray[np.intp]
    prominence: NDArray[np.float64]
    left: NDArray[np.intp]
    right: NDArray[np.intp]


def prominent_peaks(curve: NDArray[np.float64], least: float) -> Prominent:
    """Return the peaks of at least some prominence, (n,) curve without NaN."""
    place = _steep(curve, _tops(curve), least)
    left = _lowest_before(curve, place)
    right = len(curve) - 1 - _lowest_before(curve[::-1], len(curve) - 1 - place[::-1])[::-1]
    prominence = curve[place] - np.maximum(curve[left], curve[right])
    kept = prominence >= least
    return Prominent(place[kept], prominence[kept], left[kept], right[kept])


def crossings(
    curve: NDArray[np.float64], place: int, height: float, left: int, right: int
) -> tuple[float, float]:
    """Return where the curve falls below a height to both sides of a peak, between two ends."""
    first = place
    while left < first and height < curve[first]:
        first -= 1
    last = place
    while last < right and height < curve[last]:
        last += 1
    begin, end = float(first), float(last)
    if curve[first] < height:
        begin += (height - curve[first]) / (curve[first + 1] - curve[first])
    if curve[last] < height:
        end -= (height - curve[last]) / (curve[last - 1] - curve[last])
    return begin, end


def _tops(curve: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the maxima, of flat ones the middle; the ends are none."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(curve)) + 1, [len(curve)]])
    level = curve[edges[:-1]]
    is_top = np.zeros(len(level), dtype=bool)
    is_top[1:-1] = (level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])
    return np.asarray((edges[:-1][is_top] + edges[1:][is_top] - 1) // 2)


def _steep(curve: NDArray[np.float64], place: NDArray[np.intp], least: float) -> NDArray[np.intp]:
    """Return the maxima but for slight ones: the curve falls less before the next, higher one.

    Those are not prominent.  A peak that is falls farther than to any point between two of them,
    so what it is held against stays the same.
    """
    while len(place) > 1:
        height = curve[place]
        valley = np.minimum.reduceat(curve[: place[-1]], place[:-1])
        rise = np.diff(height)
        slight = np.zeros(len(place), dtype=bool)
        slight[:-1] = (rise > 0.0) & (height[:-1] - valley < least)
        slight[1:] |= (rise < 0.0) & (height[1:] - valley < least)
        if not slight.any():
            break
        place = place[~slight]
    return place


def _lowest_before(curve: NDArray[np.float64], place: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the lowest point to the left of each peak, up to where the curve is higher.

    What lies between a peak and a higher one before it was looked at for the lower ones between.
    """
    found = np.empty(len(place), dtype=np.intp)
    higher: list[tuple[float, int]] = []
    last = 0
    for number, here in enumerate(place.tolist()):
        stretch = curve[last : here + 1]
        lowest = here - int(np.argmin(stretch[::-1]))
        top = curve[here]
        while higher and higher[-1][0] <= top:
            _, before = higher.pop()
            if curve[before] < curve[lowest]:
                lowest = before
        found[number] = lowest
        higher.append((top, lowest))
        last = here
    return found
