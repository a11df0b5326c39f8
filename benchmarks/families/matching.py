"""Which mode found is which mode of the plant, and which modes a record can tell apart at all.

A mode is a pole and a shape.  A mode found may be a true one when

* its frequency is within the reach of the true one: the half-width ζf, four least deviations and
  half the drift, as squares;
* its damping ratio is within a factor of three, widened by three least deviations;
* with three channels or more the MAC of the shapes is 0.5 at least, or what its own expected loss
  leaves within two deviations.

Of all that may be, the pairing with the least sum of squared distances (in reaches and, for
frequencies alike, in 1 - MAC) counts, one to one.

Two true modes are one to a record when their poles are nearer than three least deviations or their
frequencies nearer than one line of the record, 1/T: such a group counts once in the recall; a mode
found for each of its members is right where its shape lies in the span of theirs, and no value of
it is judged.

Least deviations are those of the law (Au 2014), or of the Cramér-Rao bound where that is larger: a
pair in one channel, a mode below the noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.families.record import Record
from benchmarks.families.response import poles
from modal_core.mode import Mode
from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac

DEVIATIONS = 4.0
DAMPING_FACTOR, DAMPING_DEVIATIONS = 3.0, 3.0
LEAST_MAC, FEWEST_CHANNELS, LOSS_DEVIATIONS = 0.5, 3, 2.0
APART = 3.0
NEVER = 1e6


@dataclass(frozen=True)
class Matched:
    """Modes found and true modes, paired.

    Parameters
    ----------
    true_of : (n_found,) int array
        -1: none of the plant's.
    group : (n_modes,) int array
        Number of the group of true modes that the record cannot tell apart.
    """

    true_of: NDArray[np.int64]
    group: NDArray[np.int64]

    @property
    def alone(self) -> NDArray[np.bool_]:
        """Which true modes are alone in their group, (n_modes,)."""
        return np.asarray(np.bincount(self.group)[self.group] == 1)


def match(modes: Sequence[Mode], record: Record) -> Matched:
    """Pair modes found with true ones."""
    true_of = np.full(len(modes), -1)
    group = _groups(record)
    if modes:
        cost = _cost(modes, record, group)
        for found, true in zip(*cheapest_pairs(cost), strict=True):
            if cost[found, true] < NEVER:
                true_of[found] = true
    return Matched(true_of, group)


def reach_hz(record: Record) -> NDArray[np.float64]:
    """Return how far from a true mode a mode found may be, (n_modes,) [Hz]."""
    plant = record.plant
    parts = (
        plant.damping_ratio,
        DEVIATIONS * record.deviation[0],
        np.full(len(plant.frequency_hz), 0.5 * record.drift),
    )
    return np.asarray(plant.frequency_hz * np.sqrt(sum(part**2 for part in parts)))


def _cost(modes: Sequence[Mode], record: Record, group: NDArray[np.int64]) -> NDArray[np.float64]:
    plant = record.plant
    found_hz = np.array([mode.frequency_hz for mode in modes])
    found_zeta = np.array([max(mode.damping_ratio, 1e-9) for mode in modes])
    away = (found_hz[:, None] - plant.frequency_hz) / reach_hz(record)
    factor = np.abs(np.log(found_zeta[:, None] / plant.damping_ratio))
    most = np.log(DAMPING_FACTOR) + DAMPING_DEVIATIONS * record.deviation[1]
    if record.drift:
        # What moves looks damped by its drift as well.
        most = most + np.log1p(record.drift / plant.damping_ratio)
    alike = np.array([_alike(mode, record, group) for mode in modes])
    least = np.array([_least_mac(mode) for mode in modes])[:, None]
    cost = away**2 + (1.0 - alike) ** 2
    never = (np.abs(away) > 1.0) | (factor > most) | (alike < least)
    return np.where(never, NEVER, cost)


def _least_mac(mode: Mode) -> float:
    """Return the MAC that a mode has with the true one at least."""
    if np.isfinite(mode.shape).sum() < FEWEST_CHANNELS:
        return 0.0
    expected = 1.0 - mode.mac_loss - LOSS_DEVIATIONS * mode.mac_loss_std
    return LEAST_MAC if math.isnan(expected) else min(LEAST_MAC, expected)


def _alike(mode: Mode, record: Record, group: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the MAC with each true shape, or with the span of its group's, (n_modes,).

    Over the channels that are known.
    """
    known = np.isfinite(mode.shape)
    shape, shapes = mode.shape[known], record.plant.shapes[known]
    alike = mac(shape, shapes)[0]
    for number in np.flatnonzero(np.bincount(group) > 1):
        base = np.linalg.qr(shapes[:, group == number])[0]
        alike[group == number] = (
            np.sum(np.abs(base.conj().T @ shape) ** 2) / np.vdot(shape, shape).real
        )
    return np.asarray(alike)


def _groups(record: Record) -> NDArray[np.int64]:
    """Number true modes; those that the record cannot tell apart have one number."""
    plant = record.plant
    pole, hz = poles(plant), plant.frequency_hz
    # A pole is told as well in damping as in frequency: both by sqrt(ζ f / 2πT) [Hz].
    deviation = 2.0 * np.pi * hz * record.deviation[0]
    least = APART * np.hypot(deviation[:, None], deviation)
    one = (np.abs(pole[:, None] - pole) < least) | (
        np.abs(hz[:, None] - hz) < 1.0 / record.duration_s
    )
    group = np.arange(len(hz))
    for first, second in np.argwhere(one):
        group[group == group[second]] = group[first]
    return np.asarray(np.unique(group, return_inverse=True)[1])
