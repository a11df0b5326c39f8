"""How well channels go on as they were: one part of a course predicted from the rest of it.

Where few modes outweigh all else, what one sensor reads is a combination of what the others read,
whatever the forces are.  The combination is fitted before a moment and tried after it, or the
other way round: fitted over the longer part.

References
----------
Chow (1960), doi:10.2307/1910133 (second test: errors of a prediction against those of the fit).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from oma_identifier.synchrony.peak_course import Course
from oma_identifier.synchrony.thresholds import SYNCHRONY

RANK = 3
"""Modes that overlap at a peak, at most."""
ROWS_PER_MODE = 6
MOST_DIRECTIONS = 8
"""Of all channels at a peak; what is beyond is noise."""
NO_DIRECTION = 1e-10
"""Share of the strongest direction's power that is rounding."""
RIDGE = 1e-9
ROUNDING = 1e-12

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Sensors = Sequence[NDArray[np.int64]]
Summed = TypeVar('Summed', Real, Complex)


@dataclass(frozen=True, slots=True)
class Misfit:
    """How channels go on at one peak.

    Parameters
    ----------
    seen : (n_moments, n_channels) bool array
        The fit tells the channel from the others.
    broken : (n_moments, n_channels) bool array
        Its prediction fails, and lacks a share that matters.
    """

    seen: NDArray[np.bool_]
    broken: NDArray[np.bool_]


def misfit(course: Course, sensors: Sensors, moments: NDArray[np.int64]) -> Misfit:
    """Predict each sensor from all others.

    Parameters
    ----------
    course : Course
        Of all channels.
    sensors : sequence of int array
        Channels of each; no others take part.
    moments : (n_moments,) int64 array [ns]
        Where the course is parted.
    """
    own, is_own = _own(course.values, sensors)
    sums = _Sums.up_to_rows(regressors(course.values, sensors), own)
    place = np.searchsorted(course.time_ns, moments)
    before, every = sums.at(place), sums.at(np.full(len(place), len(course.time_ns)))
    after = every.without(before)
    later = 2 * place < len(course.time_ns)
    seen, broken = _prediction_test(before.unless(later, after), after.unless(later, before))
    found = Misfit(*np.zeros((2, len(moments), course.values.shape[1]), dtype=bool))
    for number, columns in enumerate(sensors):
        found.seen[:, columns] = seen[number][:, is_own[number]]
        found.broken[:, columns] = (broken & seen)[number][:, is_own[number]]
    return found


def parted(
    course: Course, own: NDArray[np.int64], others: Sensors, moments: NDArray[np.int64]
) -> Real:
    """Return the log-likelihood of fits to both parts, (n_moments,) array.

    Parameters
    ----------
    course, moments
        As for :func:`misfit`.
    own, others : int array, sequence of int array
        Channels that are fitted, and those of the sensors they are fitted by.
    """
    values, _ = _own(course.values, [own])
    sums = _Sums.up_to_rows(regressors(course.values, [own, *others])[:1], values)
    place = np.searchsorted(course.time_ns, moments)
    before, every = sums.at(place), sums.at(np.full(len(place), len(course.time_ns)))
    left = before.left() + every.without(before).left()
    floor = ROUNDING * every.power
    return np.asarray(-len(course.time_ns) * np.log(left + floor + 1e-300).sum(axis=(0, 2)))


def predicted(
    course: Course, own: NDArray[np.int64], others: Sensors, moment: int
) -> tuple[Complex, Complex]:
    """Return what channels show in the shorter part, and what the longer one says they would.

    The rows next to the moment are left out: they may be of both parts.

    Returns
    -------
    tuple of two (n_rows, n_own) complex arrays
    """
    regressor = regressors(course.values, [own, *others])[0]
    values = course.values[:, own]
    later, earlier = (
        course.time_ns > moment + course.step_ns,
        course.time_ns < moment - course.step_ns,
    )
    tried, fitted = (later, earlier) if later.sum() < earlier.sum() else (earlier, later)
    weight = np.linalg.lstsq(regressor[fitted], values[fitted], rcond=None)[0]
    return values[tried], regressor[tried] @ weight


def regressors(values: Complex, sensors: Sensors) -> Complex:
    """Return the strongest directions of all others in time, for each sensor.

    Returns
    -------
    (n_sensors, n_rows, n_directions) complex array
        Columns of unit length, or zero where there are no more directions.
    """
    used = np.concatenate(sensors)
    course, power, shape = np.linalg.svd(values[:, used], full_matrices=False)
    kept = slice(min(MOST_DIRECTIONS, len(power)))
    course, power, shape = course[:, kept], power[kept], shape[kept]
    own = _own(shape, [np.flatnonzero(np.isin(used, columns)) for columns in sensors])[0]
    # In the coordinates of all channels' directions: what is left of them without a sensor.
    others = np.eye(len(power)) - own @ own.conj().transpose(0, 2, 1)
    size, direction = np.linalg.eigh(power[:, None] * others * power)
    rank = min(RANK, max(1, len(values) // ROWS_PER_MODE), len(power))
    size, direction = size[:, ::-1][:, :rank], direction[:, :, ::-1][:, :, :rank]
    real = size > NO_DIRECTION * size[:, :1]
    return np.asarray(course @ (direction * real[:, None, :]))


def _own(values: Complex, sensors: Sensors) -> tuple[Complex, NDArray[np.bool_]]:
    """Return each sensor's channels, (n_sensors, n_rows, n_own), zero where it has fewer."""
    widest = max(len(columns) for columns in sensors)
    own = np.zeros((len(sensors), len(values), widest), dtype=complex)
    is_own = np.zeros((len(sensors), widest), dtype=bool)
    for number, columns in enumerate(sensors):
        own[number, :, : len(columns)] = values[:, columns]
        is_own[number, : len(columns)] = True
    return own, is_own


@dataclass(frozen=True, slots=True)
class _Sums:
    """Sums over the rows of a part: (n_sensors, n_parts, ...) arrays.

    Parameters
    ----------
    n_rows : (n_parts,) array
        Rows.
    among, across, power : array
        Products of the regressors with one another (..., n_directions, n_directions), with the
        sensor's channels (..., n_directions, n_own), and the channels' power (..., n_own).
    """

    n_rows: Real
    among: Complex
    across: Complex
    power: Real

    @classmethod
    def up_to_rows(cls, regressor: Complex, own: Complex) -> '_Sums':
        """Return the sums over the first 0, 1, 2, ... rows."""
        adjoint = regressor.conj()[:, :, :, None]
        return cls(
            np.arange(own.shape[1] + 1.0),
            _summed(adjoint * regressor[:, :, None, :]),
            _summed(adjoint * own[:, :, None, :]),
            _summed(np.abs(own) ** 2),
        )

    def at(self, places: NDArray[np.int64]) -> '_Sums':
        """Return the sums over so many rows."""
        return _Sums(
            self.n_rows[places],
            self.among[:, places],
            self.across[:, places],
            self.power[:, places],
        )

    def without(self, part: '_Sums') -> '_Sums':
        """Return the sums over all other rows."""
        return _Sums(
            self.n_rows - part.n_rows,
            self.among - part.among,
            self.across - part.across,
            self.power - part.power,
        )

    def left(self) -> Real:
        """Return the power that fits leave, (n_sensors, n_parts, n_own) array."""
        weight = np.linalg.inv(self.among + RIDGE * np.eye(self.among.shape[-1])) @ self.across
        return np.maximum(self.power - _product(weight, self.across), 0.0)

    def unless(self, swap: NDArray[np.bool_], other: '_Sums') -> '_Sums':
        """Return these parts, but others where ``swap``."""
        return _Sums(
            np.where(swap, other.n_rows, self.n_rows),
            np.where(swap[:, None, None], other.among, self.among),
            np.where(swap[:, None, None], other.across, self.across),
            np.where(swap[:, None], other.power, self.power),
        )


def _summed(products: Summed) -> Summed:
    sums = np.zeros((len(products), products.shape[1] + 1, *products.shape[2:]), products.dtype)
    np.cumsum(products, axis=1, out=sums[:, 1:])
    return sums


def _prediction_test(fitted: _Sums, tried: _Sums) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Tell where a fit sees a channel and where it fails, (n_sensors, n_parts, n_own) arrays."""
    rank = fitted.among.shape[-1]
    inverse = np.linalg.inv(fitted.among + RIDGE * np.eye(rank))
    weight = inverse @ fitted.across
    left = fitted.power - _product(weight, fitted.across)
    predicted = _product(weight, tried.among @ weight)
    lacking = np.maximum(tried.power - 2.0 * _product(weight, tried.across) + predicted, 0.0)
    n_fitted, n_tried = fitted.n_rows[:, None], tried.n_rows[:, None]
    n_free = np.maximum(n_fitted - rank, 1.0)
    # What is left of other modes grows with the forces; and the weights are uncertain.
    loudness = (_trace(tried.among) / np.maximum(n_tried, 1.0)) / (
        _trace(fitted.among) / np.maximum(n_fitted, 1.0) + 1e-300
    )
    leverage = _trace(inverse @ tried.among)
    expected = (n_tried * np.maximum(loudness, 1.0) + leverage) * np.maximum(left, 0.0) / n_free
    enough = (n_fitted > 2 * rank) & (n_tried >= 1.0)
    seen = enough & (left < SYNCHRONY.seen * fitted.power)
    by_chance = fdtrc(2.0 * np.maximum(n_tried, 1.0), 2.0 * n_free, lacking / (expected + 1e-300))
    matters = lacking > SYNCHRONY.least_share * np.maximum(tried.power, predicted)
    return seen, (by_chance < SYNCHRONY.failure_chance) & matters


def _product(first: Complex, second: Complex) -> Real:
    return np.asarray(np.sum(first.conj() * second, axis=-2).real)


def _trace(matrix: Complex) -> Real:
    return np.asarray(np.trace(matrix, axis1=-2, axis2=-1).real)[..., None]
