"""Delay columns of samples by any part of a step, block after block."""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Four points of Lagrange: 1e-5 of the amplitude at a fortieth of the rate.
REACH = 1


class DelayLine:
    """One delay for all columns, not below one step but nothing.

    Parameters
    ----------
    delay_steps : float
        At least 1.
    first : (n_columns,) array
        What went on before the beginning.
    """

    def __init__(self, delay_steps: float, first: Array) -> None:
        whole = math.floor(delay_steps)
        part = delay_steps - whole
        nodes = np.arange(-REACH, REACH + 2)
        self._weights = [
            math.prod((part - other) / (node - other) for other in nodes if other != node)
            for node in nodes
        ]
        self._oldest = whole + REACH + 1
        self._past = np.tile(np.asarray(first, float), (self._oldest, 1))

    def push(self, rows: Array) -> Array:
        """Take the next rows and return as many delayed ones, (n_rows, n_columns)."""
        joined = np.concatenate([self._past, rows])
        self._past = joined[len(rows) :]
        late = np.zeros_like(rows)
        # A node k further back than the whole part: row i + oldest - whole - k of the joined.
        for weight, node in zip(self._weights, range(-REACH, REACH + 2), strict=True):
            begin = REACH + 1 - node
            late += weight * joined[begin : begin + len(rows)]
        return late
