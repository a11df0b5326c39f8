"""Sinusoids of constant frequency and amplitude fitted to samples, all at once.

Each is y(n) = Re (a + b x) exp(i ω n) over the centred, scaled time x in -1..1: the part of b that
turns the phasor a says by how much ω is off (Gauss and Newton), so that a few rounds find the
frequencies to the precision of the samples, however strongly the lines leak into one another.
"""

from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray

N_ROUNDS = 6
ROWS_AT_ONCE = 1024
FIRST_PASS = 1e-9
"""Phase error at the ends of the record [rad] from where on another round changes nothing."""

Real = NDArray[np.float64]
Rows = NDArray[np.floating]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Sinusoids:
    """Sinusoids in several channels.

    Parameters
    ----------
    turn : (n_lines,) array [rad]
        Phase from one sample to the next.
    phasor : (n_lines, n_channels) complex array
        At the middle of the samples.
    """

    turn: Real
    phasor: Complex

    def taken_from(self, rows: Rows) -> Rows:
        """Return rows, (n_samples, n_channels), less the sinusoids, as precise as they came."""
        left = np.empty_like(rows)
        wave = np.exp(1j * np.outer(np.arange(ROWS_AT_ONCE), self.turn))
        for first in range(0, len(rows), ROWS_AT_ONCE):
            part = rows[first : first + ROWS_AT_ONCE]
            here = np.exp(1j * (first - _middle(rows)) * self.turn)[:, None] * self.phasor
            own = wave[: len(part)]
            left[first : first + len(part)] = part - (own.real @ here.real - own.imag @ here.imag)
        return left


def fit_sinusoids(rows: Rows, turn: Real, n_rounds: int = N_ROUNDS) -> Sinusoids:
    """Fit sinusoids to samples.

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Samples, offsets included.
    turn : (n_lines,) array [rad]
        Phase from one sample to the next, to less than one turn over the record.
    n_rounds : int
        Of finding it; 0: it is as given.
    """
    turn = np.array(turn, dtype=np.float64)
    most = 2.0 * np.pi / len(rows)
    for _ in range(n_rounds):
        level, change = _phasors(rows, turn)
        size = np.sum(np.abs(level) ** 2, axis=1)
        slope = np.sum(level.conj() * change, axis=1).imag
        # Over the scaled time the phase of b/a is reached at the end, half a record away.
        step = np.divide(slope, size, out=np.zeros_like(size), where=size > 0.0)
        step *= 2.0 / len(rows)
        turn = turn + np.clip(step, -most, most)
        if np.abs(step).max(initial=0.0) * len(rows) < FIRST_PASS:
            break
    return Sinusoids(turn, _phasors(rows, turn, n_powers=1)[0])


def _middle(rows: Rows) -> float:
    return 0.5 * (len(rows) - 1)


def _phasors(rows: Rows, turn: Real, n_powers: int = 2) -> Complex:
    """Return the coefficients of all powers of time, (n_powers, n_lines, n_channels).

    By least squares on the lines, their conjugates and an offset.
    """
    every = np.concatenate([turn, -turn, [0.0]])
    moments = _moments(len(rows), np.subtract.outer(every, every).ravel(), 2 * n_powers - 1)
    moments = moments.reshape(-1, len(every), len(every))
    gram = np.block([[moments[i + j] for j in range(n_powers)] for i in range(n_powers)])
    positive = _sums(rows, np.append(turn, 0.0), n_powers)
    right = np.concatenate([positive[:, :-1], positive[:, :-1].conj(), positive[:, -1:]], axis=1)
    right = right.reshape(n_powers * len(every), -1)
    found = np.linalg.lstsq(gram / len(rows), right / len(rows), rcond=1e-13)[0]
    return np.asarray(2.0 * found.reshape(n_powers, len(every), -1)[:, : len(turn)])


def _moments(n_rows: int, turn: Real, n_powers: int) -> Complex:
    """Return the sums of x^m exp(-i turn n) over the samples, (n_powers, n_turns).

    A sample's time is that of its block and that within: sums over either, multiplied, are the
    sum over all.
    """
    middle = 0.5 * (n_rows - 1)
    length = max(1, int(np.sqrt(n_rows)))
    n_blocks = n_rows // length
    rest = np.arange(n_blocks * length, n_rows, dtype=np.float64) - middle
    within = _powers(np.arange(length, dtype=np.float64) / middle, turn * middle, n_powers)
    starts = np.arange(n_blocks, dtype=np.float64) * length - middle
    blocks = _powers(starts / middle, turn * middle, n_powers)
    total = _powers(rest / middle, turn * middle, n_powers)
    for power in range(n_powers):
        for part in range(power + 1):
            total[power] += comb(power, part) * within[part] * blocks[power - part]
    return total


def _powers(time: Real, turn: Real, n_powers: int) -> Complex:
    """Return the sums of t^m exp(-i turn t), (n_powers, n_turns)."""
    wave = np.exp(-1j * np.outer(turn, time))
    return np.asarray(np.stack([wave @ time**power for power in range(n_powers)]))


def _sums(rows: Rows, turn: Real, n_powers: int) -> Complex:
    """Return the sums of x^m exp(-i turn n) y(n), (n_powers, n_turns, n_channels)."""
    middle = _middle(rows)
    total = np.zeros((n_powers, len(turn), rows.shape[1]), dtype=complex)
    wave = np.exp(-1j * np.outer(turn, np.arange(ROWS_AT_ONCE)))
    for first in range(0, len(rows), ROWS_AT_ONCE):
        part = rows[first : first + ROWS_AT_ONCE]
        begin = np.exp(-1j * turn * (first - middle))[:, None]
        own = wave[:, : len(part)]
        scaled = (np.arange(first, first + len(part)) - middle) / max(middle, 1.0)
        for power in range(n_powers):
            weighted = part * (scaled**power)[:, None]
            total[power] += begin * (own.real @ weighted + 1j * (own.imag @ weighted))
    return total
