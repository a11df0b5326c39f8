"""Lines that move taken out of samples, each with an amplitude that changes slowly.

Turned back by its phase φ(t), a line is its complex amplitude a(t), which changes where the line
crosses a mode, with the depth of a cut and where speed was read off wrongly.  The cosine transform
of the stretch over the record (its mirror image continues it, without a step at the ends) holds
the line in its first coefficients, on a floor of response.  As many of them belong to the line as
stand out of those that follow.

* The notch takes these coefficients: I - E E⁺, the projector on what is orthogonal to the columns
  cos(π j (t + ½) / n) exp(i φ(t)) of E.  It is the filter matrix that zeroes all of them and
  changes least of white response, the matrix notch filter with a moving notch.
* Variational mode decomposition takes a share 1 / (1 + 2 α ω²) of each coefficient, a Wiener
  filter about a centre that is the mean of the mode's own frequency.  The lines of one shaft are
  further apart than their widths, so that each mode is found without the others.

References
----------
Deng, Shen, Liu, Li and Peng (2023), matrix notch filter and PolyMAX in robotic milling; equations
derived here; Dragomiretskiy and Zosso (2014), doi:10.1109/TSP.2013.2288675, and Ge, Wang, Liu and
Huang (2023), doi:10.1016/j.ymssp.2023.110475 (variational mode decomposition before subspace
identification).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.numbers.indicators import normalise
from modal_core.samples import Samples
from oma_identifier.moving_lines.asked import extent, most_coefficients, orders_there
from oma_identifier.moving_lines.course import (
    cosine_coefficients,
    Course,
    few_channels,
    find_course,
    from_cosines,
    measured_course,
    scaled,
)
from oma_identifier.moving_lines.near_band import NearBand
from oma_identifier.moving_lines.thresholds import MOVING
from oma_identifier.moving_lines.wavering import wavering_course

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
LEAST_SHARE = 0.2
"""Of response that is taken with a line, from where on it may bias a mode; chosen."""
Gain = Callable[[int, int], Real]
"""Coefficients that a line has, and all that it may have, to the share of each that is taken."""
N_KEPT = 3 * MOVING.most_knots
"""Coefficients that are looked at: a line's, and those that tell what is usual beside it."""


@dataclass(frozen=True, slots=True)
class MovingLine:
    """An order of a shaft that was taken out.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Its mean.
    moved : float
        From lowest to highest over the mean.
    shape : (n_channels,) complex array [m/s²]
        Direction in which it moves the channels most, with its root mean square.
    taken : bool
        False: it must be there, as a multiple, but does not stand out enough to be taken.
    reach_hz : float [Hz]
        Up to where beside it response was taken with it: its amplitude is not constant.
    """

    frequency_hz: float
    moved: float
    shape: Complex
    reach_hz: float = 0.0
    taken: bool = True

    @property
    def wavers(self) -> bool:
        """Whether its speed was meant to be constant."""
        return self.moved < MOVING.widest_waver

    @property
    def band_hz(self) -> float:
        """Half the band in which it was, and what was taken with it [Hz]."""
        return 0.5 * self.moved * self.frequency_hz + self.reach_hz

    @property
    def mode(self) -> Mode:
        """As a harmonic at its mean frequency."""
        return Mode(self.frequency_hz, 0.0, normalise(self.shape), harmonic=True)


def by_notch(n_line: int, n_most: int) -> Real:
    """Take all of the coefficients that a line has."""
    return np.asarray((np.arange(n_most) < n_line).astype(np.float64))


def by_modes(n_line: int, n_most: int) -> Real:
    """Take a share that falls to a half at twice the coefficients that a line has."""
    return np.asarray(1.0 / (1.0 + (np.arange(n_most) / (2.0 * n_line)) ** 2))


def without_moving(
    samples: Samples, gain: Gain = by_modes
) -> tuple[Samples, tuple[MovingLine, ...]]:
    """Return samples without the lines that move, and what was taken out or must be there.

    Parameters
    ----------
    samples : Samples
        Returned as they are where no line moves.
    gain : callable
        :func:`by_notch` or :func:`by_modes`.

    Notes
    -----
    Where the speed of a spindle is known its orders are taken out first; other lines are then
    looked for as without it, those that waver last.
    """
    lines: list[MovingLine] = []
    course = measured_course(samples)
    if course is not None:
        samples, found = _without_orders(samples, course, gain)
        lines += found
    for _ in range(MOVING.most_shafts):
        course = find_course(samples)
        if course is None:
            break
        samples, found = _without_orders(samples, course, gain)
        lines += found
    course = wavering_course(samples)
    if course is not None:
        samples, found = _without_orders(samples, course, gain)
        lines += found
    return samples, tuple(lines)


def _without_orders(
    samples: Samples, course: Course, gain: Gain
) -> tuple[Samples, list[MovingLine]]:
    """Take the orders of a course, those that stronger ones hid in further rounds."""
    taken: list[MovingLine] = []
    wanted = [(hz, 0) for hz in course.orders_hz]
    tried: list[tuple[float, int]] = []
    while wanted:
        for hz, n_least in wanted:
            samples, line = _without_order(samples, course, hz, gain, n_least)
            taken += [] if line is None else [line]
        tried += wanted
        wanted = [each for each in _more(course, taken, samples) if each not in tried]
        if len(taken) >= MOVING.most_orders:
            break
    return samples, [*taken, *_not_taken(course, taken, samples)]


def _more(course: Course, taken: list[MovingLine], samples: Samples) -> list[tuple[float, int]]:
    """Return the orders that were not seen before [Hz], and how many coefficients they have."""
    seen = [(hz, 0) for hz in course.with_orders_of(samples).orders_hz]
    if taken:
        strongest = sorted(taken, key=lambda line: -float(np.linalg.norm(line.shape)))
        found_hz = np.array([line.frequency_hz for line in strongest])
        near = NearBand.of(scaled(course.standing_still(samples)), samples.sample_rate_hz)
        seen += orders_there(near, found_hz, course)
    new: list[tuple[float, int]] = []
    for hz, n_least in seen:
        if not _is_known(hz, taken, samples.duration_s) and all(
            abs(hz - other) * samples.duration_s >= MOVING.most_knots for other, _ in new
        ):
            new.append((hz, n_least))
    return new


def _not_taken(course: Course, taken: list[MovingLine], samples: Samples) -> list[MovingLine]:
    """Return the multiples of a speed that wavers which do not stand out enough to be taken."""
    nothing = np.zeros(len(samples.channels), dtype=complex)
    hidden = [
        MovingLine(hz, course.moved, nothing, taken=False)
        for hz in _multiples(course, taken, samples)
        if not _is_known(hz, taken, samples.duration_s)
    ]
    return [line for line in hidden if line.wavers]


def _multiples(course: Course, taken: list[MovingLine], samples: Samples) -> list[float]:
    """Return the multiples of the lowest order, where all others are some.

    Where the speed is measured it is the lowest order.  An order that crosses a mode grows and
    falls too much to be narrow in any time.
    """
    found_hz = np.array([line.frequency_hz for line in taken])
    least_hz = course.least_hz(samples.duration_s)
    highest_hz = MOVING.highest * samples.sample_rate_hz
    base_hz = course.base_hz or _base_hz(found_hz, samples.duration_s)
    if not base_hz > 0.0:
        return []
    every_hz = base_hz * np.arange(1, int(highest_hz / base_hz) + 1)
    return [float(hz) for hz in every_hz[every_hz >= least_hz]]


def _base_hz(found_hz: Real, duration_s: float) -> float:
    """Return of what frequency all others are multiples, 0: of none [Hz].

    It is the lowest one or, where that stands still or hides, a fraction of it; then the others
    must fit too well for chance.
    """
    lowest_hz = found_hz.min(initial=np.inf)
    if not len(found_hz):
        return 0.0
    for part in range(1, MOVING.lowest_order + 1):
        base_hz = lowest_hz / part
        off_hz = np.abs(found_hz - base_hz * np.round(found_hz / base_hz))
        within_hz = (MOVING.most_knots if part == 1 else MOVING.same_order) / duration_s
        chance = part * (2.0 * within_hz / base_hz) ** (len(found_hz) - 1)
        if off_hz.max() <= within_hz and (part == 1 or chance < MOVING.base_by_chance):
            return float(base_hz)
    return 0.0


def _is_known(hz: float, taken: list[MovingLine], duration_s: float) -> bool:
    return any(abs(hz - line.frequency_hz) * duration_s < MOVING.most_knots for line in taken)


def _without_order(
    samples: Samples, course: Course, hz: float, gain: Gain, n_least: int
) -> tuple[Samples, MovingLine | None]:
    rows, few = samples.widened(), few_channels(samples)
    for is_centred in (False, True):
        turn = np.exp(2j * np.pi * hz * course.own_time_s)
        level = _coefficients(rows, turn, N_KEPT)
        n_line = max(n_least, extent(level[:, few], most_coefficients(course.moved)))
        if n_line == 0:
            return samples, None
        if not is_centred:
            amplitude = _in_time(level[:n_line], np.ones(n_line), len(rows))
            off = np.sum(amplitude[1:] * amplitude[:-1].conj())
            hz += float(np.angle(off)) * samples.sample_rate_hz / (2.0 * np.pi)
    share = gain(n_line, MOVING.most_knots)
    n_reach = int(np.count_nonzero(share > LEAST_SHARE))
    reach_hz = 0.5 * n_reach / samples.duration_s
    amplitude = _in_time(level[: len(share)], share, len(rows))
    left = rows - 2.0 * (amplitude * turn[:, None]).real
    values, vectors = np.linalg.eigh(amplitude.T @ amplitude.conj() / len(rows))
    shape = vectors[:, -1] * np.sqrt(max(values[-1], 1e-300))
    return replace(samples, acceleration=left), MovingLine(hz, course.moved, shape, reach_hz)


def _coefficients(rows: Real, turn: Complex, n_kept: int) -> Complex:
    """Return the first cosine coefficients of rows turned back, (n_kept, n_channels)."""
    return cosine_coefficients(turn.conj()[:, None] * rows)[:n_kept]


def _in_time(level: Complex, share: Real, n_rows: int) -> Complex:
    whole = np.zeros((n_rows, level.shape[1]), dtype=complex)
    whole[: len(level)] = share[:, None] * level
    return from_cosines(whole)
