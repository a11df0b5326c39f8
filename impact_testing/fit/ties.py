"""Whether a point that was hit is the channel that it is named for: by what is the same both ways.

A structure with symmetric matrices answers at one place to a force at another as the other way
round, sign and all.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from impact_testing.responses import PointData

Complex = NDArray[np.complex128]
LEAST_ALIKE = np.sqrt(0.95)
"""Correlation of two FRFs that should be one: FRAC of 0.95 by common practice, sign and all."""
BEYOND_NOISE = 4.0
"""Mean square of a difference over its noise: noise itself reaches half of it."""


def loose_points(data: Sequence[PointData]) -> tuple[int, ...]:
    """Return points whose FRFs are not those of the others the other way round, worst first.

    A point is given up when that holds with at least half of the others.
    """
    pairs = list(_pairs(data))
    loose: list[int] = []
    while True:
        worst, share = -1, 0.0
        for number in range(len(data)):
            found = [bad for i, j, bad in pairs if number in (i, j) and not {i, j} & set(loose)]
            if found and float(np.mean(found)) > share:
                worst, share = number, float(np.mean(found))
        if share < 0.5:
            return tuple(loose)
        loose.append(worst)


def _pairs(data: Sequence[PointData]) -> Iterator[tuple[int, int, bool]]:
    """Yield pairs of points that have FRFs in common, and whether these differ; later first."""
    for second in range(len(data) - 1, 0, -1):
        for first in range(second - 1, -1, -1):
            one, other = data[second], data[first]
            p, q = one.frf.spectra.record.point, other.frf.spectra.record.point
            names, others = one.frf.spectra.names, other.frf.spectra.names
            if p == q and p in names:
                both = [
                    (names.index(each), others.index(each)) for each in names if each in others
                ]
            elif q in names and p in others:
                both = [(names.index(q), others.index(p))]
            else:
                continue
            mine, theirs = (list(each) for each in zip(*both, strict=True))
            yield second, first, _differ(one, mine, other, theirs)


def _differ(one: PointData, mine: list[int], other: PointData, theirs: list[int]) -> bool:
    noise = 2.0 * (
        one.course[:, None] * one.level[mine] + other.course[:, None] * other.level[theirs]
    )
    a = one.frf.h1[one.lines][:, mine] / np.sqrt(noise)
    b = other.frf.h1[other.lines][:, theirs] / np.sqrt(noise)
    alike = np.vdot(a, b).real / (np.linalg.norm(a) * np.linalg.norm(b) + 1e-300)
    beyond = float(np.mean(np.abs(a - b) ** 2))
    return bool(alike < LEAST_ALIKE and beyond > BEYOND_NOISE)
