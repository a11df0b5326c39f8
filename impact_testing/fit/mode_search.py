"""Which modes there are: some to begin with, more as long as they explain what chance does not."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit.first_shapes import first_shapes
from impact_testing.fit.free_fit import free_fit
from impact_testing.fit.further_mode import chance_gain, further_mode, trial_poles
from impact_testing.fit.likely_force import force_doubts, with_common_noise, with_likely_force
from impact_testing.fit.modal_model import climb, evaluate, ModalModel
from impact_testing.fit.places import Places
from impact_testing.fit.ringing import rings_on, tuned, without_ringing
from impact_testing.fit.start_poles import start_poles
from impact_testing.fit.ties import loose_points
from impact_testing.responses import PointData
from modal_core.errors import IdentificationError

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
MOST_ADDED = 20
"""In one round: where the model does not hold, no number of modes does."""
ACCURACY = 1e-3
"""Of accelerometers, force sensors and their filters none is known better (0.1 %)."""
ROUNDS, MOST_ROUNDS = 2, 6
"""Weights settle when what ends of segments explain is taken out of the noise twice; more often
where modes ring on from tap to tap."""
LEAST_FALL = 0.05
"""Of the noise's logarithm, the mean over lines and channels: a fortieth of each σ."""


def fitted(data: Sequence[PointData]) -> tuple[list[PointData], ModalModel]:
    """Fit poles and shapes; a point that is not where it is named has a place of its own."""
    now = list(data)
    pole = start_poles(now)
    places = Places.of(now, loose_points(now))
    now, pole = tuned(now, pole)
    model = climb(now, places, pole, first_shapes(free_fit(now, pole), places))
    for done in range(MOST_ROUNDS):
        before = sum(each.log_noise for each in now)
        # What former taps left looks like noise until the modes are known.
        now = [
            _likely(each, data[n], model.pole, model.amplitude(n)) for n, each in enumerate(now)
        ]
        fallen = before - sum(each.log_noise for each in now)
        if done >= ROUNDS and fallen < LEAST_FALL * sum(each.target.size for each in now):
            break
        now, model = _completed(now, climb(now, places, model.pole, model.shape))
        model = _pruned(now, model)
    if not len(model.pole):
        raise IdentificationError('no mode stands out of the noise')
    return _with_force_noise(now, data, model)


def refitted(
    data: Sequence[PointData], model: ModalModel, wrong: Sequence[int] = ()
) -> ModalModel:
    """Climb again, with points that have places of their own instead of a channel's.

    Parameters
    ----------
    data : sequence of PointData
        As :func:`fitted` returns it.
    model : ModalModel
    wrong : sequence of int
        Points.
    """
    before, n_poles = model.places, len(model.pole)
    places = Places.of(data, (*before.loose, *wrong))
    shape = np.zeros((n_poles, places.n), dtype=complex)
    for name in before.names:
        if name in places.names:
            shape[:, places.names.index(name)] = model.shape[:, before.names.index(name)]
    shape[:, list(places.into)] = model.shape[:, list(before.into)]
    doubts = [force_doubts(each, model.pole, model.amplitude(n)) for n, each in enumerate(data)]
    return climb(data, places, model.pole, shape, doubts=doubts)


def _with_force_noise(
    now: Sequence[PointData], data: Sequence[PointData], model: ModalModel
) -> tuple[list[PointData], ModalModel]:
    """Climb and prune once more, with the noise that the forces of each point have in common."""
    each = range(len(now))
    now = [with_common_noise(now[n], data[n]) for n in each]
    doubts = [force_doubts(now[n], model.pole, model.amplitude(n)) for n in each]
    model = climb(now, model.places, model.pole, model.shape, doubts=doubts)
    return now, _pruned(now, model, doubts)


def _likely(now: PointData, given: PointData, pole: Complex, amplitude: Complex) -> PointData:
    """Return forces and noise as they are most likely under a model."""
    likely = with_likely_force(now, given, pole, amplitude)
    return without_ringing(likely, pole, amplitude)


def _completed(data: Sequence[PointData], model: ModalModel) -> tuple[list[PointData], ModalModel]:
    """Add modes one by one, as long as one explains more than chance and the chain do.

    One that rings on from tap to tap is seen by the FRFs only roughly, and moves its neighbours.
    What one promised where it was tried it need not keep: one that would be left out again ends
    the search.
    """
    now, chance = list(data), _chance(data)
    for _ in range(MOST_ADDED):
        more = further_mode(now, model)
        if more is None:
            break
        fresh, pole, shape = now, np.append(model.pole, more[0]), np.vstack([model.shape, more[1]])
        if rings_on(now, pole)[-1]:
            fresh, pole = tuned(now, pole)
            shape = first_shapes(free_fit(fresh, pole), model.places)
        longer = climb(fresh, model.places, pole, shape)
        before = evaluate(fresh, model.places, model.pole, model.shape)
        if sum(before.cost) - sum(longer.cost) < _least_gain(
            fresh, longer, complex(more[0]), chance
        ):
            break
        now, model = fresh, longer
    return now, model


def _pruned(
    data: Sequence[PointData], model: ModalModel, doubts: Sequence[Real] = ()
) -> ModalModel:
    """Leave out each that explains no more than chance, or the measuring chain, does.

    All that are weak by curvature are tried, the weakest first: of two that stand for one mode
    each is weak, and needed as long as the other is where it is.  The sum of squares decides.
    """
    chance = _chance(data)
    needed = np.zeros(len(model.pole), dtype=bool)
    while not needed.all():
        strength = np.where(needed, np.inf, model.strength())
        weakest = int(np.argmin(strength))
        if strength[weakest] > chance:
            break
        least = sum(model.cost) + _least_gain(data, model, complex(model.pole[weakest]), chance)
        less = _without(data, model, weakest, least, doubts)
        if sum(less.cost) > least:
            needed[weakest] = True
        else:
            model = climb(data, model.places, less.pole, less.shape, doubts=doubts)
            needed = np.delete(needed, weakest)
    return model


def _chance(data: Sequence[PointData]) -> float:
    return chance_gain(data, len(trial_poles(data[0].frequency_hz)))


def _least_gain(
    data: Sequence[PointData], model: ModalModel, pole: complex, chance: float
) -> float:
    """Return the sum of squares that a mode must explain."""
    return max(1.0, model.misfit) * chance + _inaccuracy(data, pole)


def _inaccuracy(data: Sequence[PointData], pole: complex) -> float:
    """Return the sum of squares by which FRFs may be wrong within a pole's half-power band."""
    total = 0.0
    for each in data:
        near = np.abs(2.0 * np.pi * each.frequency_hz - pole.imag) < -pole.real
        total += float(np.sum(np.abs(each.target[near]) ** 2))
    return ACCURACY**2 * total


def _without(
    data: Sequence[PointData],
    model: ModalModel,
    mode: int,
    enough: float,
    doubts: Sequence[Real],
) -> ModalModel:
    """Climb without a mode as far as a cost.

    From its neighbours as they are, or from what the poles tell alone.
    """
    places, pole = model.places, np.delete(model.pole, mode)
    starts = [np.delete(model.shape, mode, axis=0)]
    if len(pole):
        starts.append(first_shapes(free_fit(data, pole), places))
    costs = [sum(evaluate(data, places, pole, each, doubts).cost) for each in starts]
    return climb(data, places, pole, starts[int(np.argmin(costs))], enough, doubts)
