"""Numbers for the charts' scripts: seven digits, what is not finite as null."""

import math

import numpy as np
from numpy.typing import NDArray

DIGITS = 7
EXACT = 22
"""Largest power of ten that a double holds exactly."""


def number(value: float) -> float | None:
    """Return a number as strict JSON has it."""
    return float(f'{value:.{DIGITS}g}') if math.isfinite(value) else None


def numbers(values: NDArray[np.float64]) -> list[object]:
    """Return an array as nested lists, all at once: charts have thousands."""
    plain = np.asarray(values, dtype=np.float64)
    known = np.isfinite(plain)
    size = np.abs(np.where(known & (plain != 0.0), plain, 1.0))
    # Of digits and decade a division by a power of ten makes the nearest number to their decimal,
    # as reading it would; powers up to the 22nd are exact.
    decade = np.floor(np.log10(size)).astype(int) - (DIGITS - 1)
    if decade.size == 0 or decade.min() < -EXACT or decade.max() > 0:
        return _one_by_one(plain)
    power = 10.0**-decade
    rounded = np.where(known, np.rint(plain * power) / power, np.nan)
    if known.all():
        return list(rounded.tolist())
    shown = rounded.astype(object)
    shown[~known] = None
    return list(shown.tolist())


def _one_by_one(values: NDArray[np.float64]) -> list[object]:
    if values.ndim > 1:
        return [_one_by_one(row) for row in values]
    return [number(value) for value in values.tolist()]
