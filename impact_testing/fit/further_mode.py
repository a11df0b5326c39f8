"""Where one more mode explains most of what is left, and how much chance explains.

What is left times the bell of a trial pole is one value per FRF: a table of channels by points
hit, of which a mode explains the part of rank one.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit.likely_force import force_doubt
from impact_testing.fit.modal_model import Doubts, ModalModel, remainder
from impact_testing.fit.places import Places
from impact_testing.fit.start_poles import BEYOND
from impact_testing.responses import apart, bells, PointData
from impact_testing.thresholds import IMPACT

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
SHARP, BROAD = (0.003,), (0.01, 0.03, 0.1)
"""A bell between two of these overlaps with the nearer by more than nine tenths."""
ACCURACY = 1e-3
"""Of accelerometers, force sensors and their filters none is known better (0.1 %)."""
AT_ONCE = 1 << 20
"""Values of bells worked out together: memory of this size is used again, not asked for anew."""
STEP = 1.4
"""Between trial frequencies, in half-widths of their bells."""


def further_mode(
    data: Sequence[PointData], model: ModalModel, doubts: Sequence[Doubts] = ()
) -> tuple[complex, Complex] | None:
    """Return pole and shape that explain most, None where chance explains as much.

    One at a time: what a strong mode has left shows under its skirts everywhere.  The many sharp
    bells are tried where no broad one is left.

    Parameters
    ----------
    data : sequence of PointData
    model : ModalModel
        Of the modes there are.
    doubts : sequence of Doubts
        See :func:`evaluate`.
    """
    trials = [trial_poles(data[0].frequency_hz, dampings) for dampings in (BROAD, SHARP)]
    least = max(1.0, model.misfit) * chance_gain(data, sum(map(len, trials)))
    for trial in trials:
        found = _strongest(data, model, trial, doubts)
        if found[0] > least:
            return found[1:]
    return None


def _strongest(
    data: Sequence[PointData], model: ModalModel, trial: Complex, doubts: Sequence[Doubts]
) -> tuple[float, complex, Complex]:
    """Return what the best trial explains beyond what FRFs may be wrong, its pole and shape."""
    table = np.zeros((len(trial), model.places.n, len(data)), dtype=complex)
    size = np.zeros((len(trial), len(data)))
    for number, each in enumerate(data):
        left, _, directions = remainder(each, model.pole, model.amplitude(number))
        if doubts:
            left = doubts[number].without_likely(left)
        at_once = max(1, AT_ONCE // len(left))
        for first in range(0, len(trial), at_once):
            some = slice(first, first + at_once)
            size[some, number], found = _scores(each, left, directions, trial[some])
            table[some, model.places.out[number], number] = found
    table /= np.sqrt(size)[:, None]
    products = np.einsum('tpi,tpj->tij', table.conj(), table, optimize=True)
    gain = np.linalg.eigvalsh(products)[:, -1] - inaccuracy(data, trial, bool(doubts))
    best = int(np.argmax(gain))
    shape = _shape(table[best], size[best], data, model.places)
    return float(gain[best]), complex(trial[best]), shape


def chance_gain(data: Sequence[PointData], n_trials: int) -> float:
    """Return what noise of one explains by rank one at the best trial, but once in a thousand.

    The largest squared singular value of complex noise, and the right tail of its law of Tracy and
    Widom, exp(-4/3 s^(3/2)).

    References
    ----------
    Johansson (2000), doi:10.1007/s002200050027.
    """
    rows, columns = np.sqrt(max(len(each.level) for each in data)), np.sqrt(len(data))
    tail = (0.75 * np.log(n_trials / IMPACT.false_modes)) ** (2.0 / 3.0)
    spread = (rows + columns) * (1.0 / rows + 1.0 / columns) ** (1.0 / 3.0)
    # Real and imaginary parts have a variance of one each.
    return float(2.0 * ((rows + columns) ** 2 + tail * spread))


def trial_poles(frequency_hz: Real, dampings: Sequence[float] = SHARP + BROAD) -> Complex:
    """Return poles that leave no place untried in the band and beyond it, (n_trials,) array."""
    low, high = float(frequency_hz[0]), float(frequency_hz[-1])
    line = float(frequency_hz[1] - frequency_hz[0])
    found = []
    for damping in dampings:
        at = low
        while at < BEYOND * high:
            found.append(2.0 * np.pi * at * complex(-damping, np.sqrt(1.0 - damping**2)))
            # From beyond the end only skirts reach into the band.
            at += max(STEP * damping * at, line, 0.5 * (at - high))
    return np.asarray(found)


def _scores(data: PointData, left: Real, directions: Real, trial: Complex) -> tuple[Real, Complex]:
    """Return squared sizes of the trial functions, and their products with what is left."""
    noise = np.sqrt(data.course)[:, None]
    added = apart(bells(data, trial) / noise)
    added -= directions @ (directions.T @ added)
    size = 0.5 * np.sum(added**2, axis=0).reshape(-1, 2).sum(axis=1)
    seen = (added.T @ left).reshape(len(trial), 2, -1)
    return size, np.asarray(seen[:, 0] + 1j * seen[:, 1])


def inaccuracy(data: Sequence[PointData], pole: Complex, force_known: bool) -> Real:
    """Return sums of squares by which FRFs may be wrong in half-power bands, (n_poles,) array.

    Parameters
    ----------
    force_known : bool
        Whether the noise of the force is in the model.
    """
    total = np.zeros(len(pole))
    for each in data:
        wrong = ACCURACY**2 + (0.0 if force_known else force_doubt(each))
        power = np.append(0.0, np.cumsum(wrong * np.sum(np.abs(each.target) ** 2, axis=1)))
        omega = 2.0 * np.pi * each.frequency_hz
        low, high = np.searchsorted(omega, [pole.imag + pole.real, pole.imag - pole.real])
        total += power[high] - power[low]
    return total


def _shape(scaled: Complex, size: Real, data: Sequence[PointData], places: Places) -> Complex:
    """Return the shape whose products come nearest to a table."""
    left, value, right = np.linalg.svd(scaled, full_matrices=False)
    level = np.ones(places.n)
    for each, out in zip(data, places.out, strict=True):
        level[out] = each.level
    shape = left[:, 0] * np.sqrt(level)
    into = np.array(places.into)
    hit = right[0] / np.sqrt(size) * value[0]
    # One scale for all, by the points that were hit; those without a channel get theirs whole.
    tied = np.abs(shape[into]) > 0.0
    if tied.any():
        own = shape[into[tied]]
        factor = np.vdot(own, hit[tied]) / np.vdot(own, own)
        shape = shape * np.sqrt(factor)
        hit = hit / np.sqrt(factor)
    shape[into[~tied]] = hit[~tied]
    return np.asarray(shape)
