"""Numbers for the charts' scripts: seven digits, what is not finite as null."""

import math

import numpy as np
from numpy.typing import NDArray

DIGITS = 7


def number(value: float) -> float | None:
    """Return a number as strict JSON has it."""
    return float(f'{value:.{DIGITS}g}') if math.isfinite(value) else None


def numbers(values: NDArray[np.float64]) -> list[object]:
    """Return an array as nested lists."""
    if values.ndim > 1:
        return [numbers(row) for row in values]
    return [number(value) for value in values]
