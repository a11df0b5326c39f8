"""Digital filters: a low-pass of finite length, and a high-pass that runs in blocks of rows.

SciPy has both behind a package that brings 25 MB of others along.
"""

from dataclasses import dataclass
from functools import lru_cache
import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0

BLOCK = 32
"""Rows filtered as one product of matrices."""

Real = NDArray[np.float64]


def kaiser_low_pass(n_taps: int, cutoff: float, attenuation_db: float) -> Real:
    """Return the taps of a low-pass filter of linear phase, 1 at frequency 0.

    Parameters
    ----------
    n_taps : int
        Odd.
    cutoff : float
        In the middle of the transition, over half the sample rate.
    attenuation_db : float [dB]
        Above 50.

    References
    ----------
    Oppenheim and Schafer, Discrete-Time Signal Processing, 3rd ed., eqs. 7.72 and 7.75.
    """
    beta = 0.1102 * (attenuation_db - 8.7)
    middle = 0.5 * (n_taps - 1)
    place = np.arange(n_taps) - middle
    window = i0(beta * np.sqrt(1.0 - (place / middle) ** 2)) / i0(beta)
    taps = cutoff * np.sinc(cutoff * place) * window
    return np.asarray(taps / taps.sum())


def butterworth_high_pass(order: int, corner: float) -> Real:
    """Return second-order sections (b0, b1, b2, 1, a1, a2), (order / 2, 6) array.

    Parameters
    ----------
    order : int
        Even.
    corner : float
        -3 dB, over the sample rate.

    References
    ----------
    Oppenheim and Schafer, 3rd ed., section 7.2 and appendix B (bilinear transform).
    """
    angle = np.pi * (2.0 * np.arange(order // 2) + 1.0) / (2.0 * order)
    # Poles in the left half plane, those next to the unit circle last.
    analog = 2.0 * math.tan(math.pi * corner) * np.exp(1j * (np.pi - angle))
    pole = (2.0 + analog) / (2.0 - analog)
    sections = np.empty((order // 2, 6))
    sections[:, :3] = np.abs(1.0 + pole[:, None]) ** 2 / 4.0 * [1.0, -2.0, 1.0]
    sections[:, 3:] = np.column_stack([np.ones(len(pole)), -2.0 * pole.real, np.abs(pole) ** 2])
    return sections


@dataclass(frozen=True, slots=True)
class _Block:
    """What some rows of a filter give: ``outputs = direct·inputs + free·state``, and its state.

    Parameters
    ----------
    direct : (n_rows, n_rows) array
        Outputs by inputs.
    free : (n_rows, n_states) array
        Outputs by the state before the rows.
    driven : (n_states, n_rows) array
        State after the rows, by inputs.
    kept : (n_states, n_states) array
        State after the rows, by that before.
    """

    direct: Real
    free: Real
    driven: Real
    kept: Real


class RunningFilter:
    """Filters rows that follow one another, all channels alike.

    Parameters
    ----------
    sections : (n_sections, 6) array
        As of :func:`butterworth_high_pass`.
    """

    def __init__(self, sections: Real) -> None:
        self._sections = tuple(map(tuple, sections.tolist()))
        self._state: Real | None = None

    def filter(self, rows: Real) -> Real:
        """Filter the next rows, (n_samples, n_channels) in and out.

        Before the first row it is taken to have been there for ever.
        """
        state = self._resting(rows[0]) if self._state is None else self._state
        block = _block(self._sections, BLOCK)
        n_whole = len(rows) // BLOCK
        blocks = rows[: n_whole * BLOCK].reshape(n_whole, BLOCK, rows.shape[1])
        filtered = np.empty_like(rows)
        whole = filtered[: n_whole * BLOCK].reshape(blocks.shape)
        np.matmul(block.direct, blocks, out=whole)
        for out, driven in zip(whole, block.driven @ blocks, strict=True):
            out += block.free @ state
            state = block.kept @ state + driven
        if rest := len(rows) - n_whole * BLOCK:
            block, left = _block(self._sections, rest), rows[-rest:]
            filtered[-rest:] = block.direct @ left + block.free @ state
            state = block.kept @ state + block.driven @ left
        self._state = state
        return filtered

    def _resting(self, row: Real) -> Real:
        """Return the state that a constant row leaves, (n_states, n_channels) array."""
        block = _block(self._sections, 1)
        rest = np.linalg.solve(np.eye(len(block.kept)) - block.kept, block.driven)
        return np.asarray(rest * row)


@lru_cache(maxsize=256)
def _block(sections: tuple[tuple[float, ...], ...], n_rows: int) -> _Block:
    """Return the block of so many rows: what unit inputs and unit states give."""
    n_states = 2 * len(sections)
    inputs = np.hstack([np.eye(n_rows), np.zeros((n_rows, n_states))])
    state = np.hstack([np.zeros((n_states, n_rows)), np.eye(n_states)])
    outputs = np.empty_like(inputs)
    for row, value in enumerate(inputs):
        for number, (b0, b1, b2, _, a1, a2) in enumerate(sections):
            first, second = state[2 * number], state[2 * number + 1]
            out = b0 * value + first
            state[2 * number] = b1 * value - a1 * out + second
            state[2 * number + 1] = b2 * value - a2 * out
            value = out
        outputs[row] = value
    return _Block(outputs[:, :n_rows], outputs[:, n_rows:], state[:, :n_rows], state[:, n_rows:])
