"""What a natural frequency depends on beside stiffness: pose, load, temperature."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from modal_history.trend import Trend

Array = NDArray[np.float64]
NEVER_MOVED_RAD = 0.01
"""A joint that stood within this takes no part."""
TEMPERATURE_C, TEMPERATURE_PRIOR = 10.0, 0.02
"""Frequencies of machines move by about a per cent or two in ten degrees: 95 % within this."""
SOAKING_S = 2.0 * 3600.0
"""Thick castings follow the air with hours of delay."""
LEVEL_PRIOR = 10.0
MOST_PLACES = 120
LEAST_NEW = 1e-4
"""Variance that the places taken so far leave of any other, above which one more is taken."""


@dataclass(frozen=True, slots=True)
class Covariates:
    """Terms that the logarithm of a frequency is a sum of.

    Of pose and load it is a smooth function that nobody needs to know: a Gaussian process over
    cosine and sine of each joint and the load, by the places that tell most of it.

    Parameters
    ----------
    joints : tuple of int
        Those that moved.
    temperature, load : tuple of (float, float) or None
        Middle and unit; None where not known, or always the same.
    reach : float
        Distance over which the function stays alike; an angle of 1 rad is about 1.
    places : (n_places, n_coordinates) array
        Poses and loads that tell most.
    root : (n_places, n_places) array
        Lower Cholesky factor of their covariance.
    """

    joints: tuple[int, ...]
    temperature: tuple[float, float] | None
    load: tuple[float, float] | None
    reach: float
    places: Array
    root: Array

    def terms(self, trend: Trend) -> Array:
        """Return one row per estimate, NaN where something is not known."""
        columns = [np.ones(len(trend))]
        if self.temperature is not None:
            warm = (trend.temperature_c - self.temperature[0]) / self.temperature[1]
            columns += [warm, warm**2, soaked(trend.time_ns, warm)]
        coordinates = coordinates_of(trend, self.joints, self.load)
        known = np.isfinite(coordinates).all(axis=1)
        alike = _alike(np.nan_to_num(coordinates), self.places, self.reach)
        places = solve_triangular(self.root, alike.T, lower=True).T
        places[~known] = np.nan
        return np.column_stack([*columns, places])

    def precision(self, amplitude: float) -> Array:
        """Return one over the squared prior deviation of each term's factor."""
        n_warm = 3 * (self.temperature is not None)
        prior = [LEVEL_PRIOR, *[TEMPERATURE_PRIOR] * n_warm, *[amplitude] * len(self.places)]
        return np.asarray(np.array(prior) ** -2.0)

    def untold(self, terms: Array) -> Array:
        """Return the share of a squared amplitude that the places tell nothing of."""
        if not len(self.places):
            return np.zeros(len(terms))
        told = np.sum(terms[:, -len(self.places) :] ** 2, axis=1)
        return np.asarray(np.clip(1.0 - told, 0.0, 1.0))

    def nearest(self, terms: Array) -> NDArray[np.int64]:
        """Return the place each row is nearest to; 0 where there is none."""
        if not len(self.places):
            return np.zeros(len(terms), dtype=np.int64)
        return np.asarray(np.argmax(terms[:, -len(self.places) :] @ self.root.T, axis=1))


def covariates_of(trend: Trend, reach: float) -> Covariates:
    """Return what varied while the baseline was learnt."""
    joints = tuple(
        place for place, angles in enumerate(trend.position.T) if _spread(angles) > NEVER_MOVED_RAD
    )
    load = (0.0, _spread(trend.load_kg)) if _spread(trend.load_kg) > 0.0 else None
    warm = trend.temperature_c
    temperature = (float(np.nanmean(warm)), TEMPERATURE_C) if _spread(warm) > 0.0 else None
    coordinates = coordinates_of(trend, joints, load)
    known = coordinates[np.isfinite(coordinates).all(axis=1)]
    places, root = _telling(known, reach) if known.shape[1] else (known[:0], np.empty((0, 0)))
    return Covariates(joints, temperature, load, reach, places, root)


def coordinates_of(
    trend: Trend, joints: tuple[int, ...], load: tuple[float, float] | None
) -> Array:
    """Return where each estimate was, in poses and loads."""
    columns = []
    for joint in joints:
        angle = trend.position[:, joint]
        columns += [np.cos(angle), np.sin(angle)]
    if load is not None:
        columns.append((trend.load_kg - load[0]) / load[1])
    return np.column_stack(columns) if columns else np.empty((len(trend), 0))


def soaked(time_ns: NDArray[np.int64], values: Array) -> Array:
    """Return values as a body follows them that takes hours to warm up."""
    found, now = np.empty(len(values)), math.nan
    stays = np.exp(-np.diff(time_ns, prepend=time_ns[:1]) / 1e9 / SOAKING_S)
    for place, value in enumerate(values.tolist()):
        if math.isfinite(value):
            now = value + stays[place] * (now - value) if math.isfinite(now) else value
        found[place] = now
    return found


def _telling(coordinates: Array, reach: float) -> tuple[Array, Array]:
    """Return the places that tell most of all others, by a pivoted Cholesky factorisation."""
    left, rows = np.ones(len(coordinates)), np.empty((0, len(coordinates)))
    chosen: list[int] = []
    while len(chosen) < MOST_PLACES and left.max() > LEAST_NEW:
        pivot = int(np.argmax(left))
        alike = _alike(coordinates, coordinates[[pivot]], reach)[:, 0]
        row = (alike - rows.T @ rows[:, pivot]) / math.sqrt(left[pivot])
        rows, left = np.vstack([rows, row]), np.maximum(left - row**2, 0.0)
        left[pivot] = 0.0
        chosen.append(pivot)
    return coordinates[chosen], np.tril(rows[:, chosen].T)


def _alike(first: Array, second: Array, reach: float) -> Array:
    squared = np.sum(first**2, axis=1)[:, None] + np.sum(second**2, axis=1)[None]
    squared -= 2.0 * first @ second.T
    return np.asarray(np.exp(-0.5 * np.maximum(squared, 0.0) / reach**2))


def _spread(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if len(known) else 0.0
