"""Which modes there are: some to begin with, more as long as they explain what chance does not."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit.first_shapes import first_shapes
from impact_testing.fit.free_fit import free_fit
from impact_testing.fit.further_mode import chance_gain, further_mode, inaccuracy, trial_poles
from impact_testing.fit.likely_force import force_doubts, with_likely_force
from impact_testing.fit.modal_model import climb, Doubts, evaluate, ModalModel
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
SETTLED = 0.01
"""Share of what a mode must explain that a step promises at least while modes are looked for."""
ROUNDS, MOST_ROUNDS = 2, 6
"""Weights settle when what ends of segments explain is taken out of the noise twice; more often
where modes ring on from tap to tap."""
N_RESIDUAL = 5
"""Terms of the final fit: noise of the force explains what three leave of modes above the band,
and skirts of modes then tell wrong masses.  Of 30 random tests (982000 to 982029) the rms error of
masses fell from 2.0 to 1.7 deviations with them and with trial poles beyond the band."""
FORCE_ROUNDS = 3
"""FRFs are linear in the noise of the force about where it is most likely only; with more rounds
three tests of four stayed as they were."""
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
    now, doubts = [replace(each, n_residual=N_RESIDUAL) for each in now], list[Doubts]()
    for _ in range(FORCE_ROUNDS):
        each = [(number, model.pole, model.amplitude(number)) for number in range(len(now))]
        now = [_likely(now[n], data[n], pole, amplitude) for n, pole, amplitude in each]
        doubts = [force_doubts(now[n], pole, amplitude) for n, pole, amplitude in each]
        model = climb(now, model.places, model.pole, model.shape, doubts=doubts)
    now, longer = _completed(now, model, doubts)
    return now, _pruned(now, longer, doubts)


def _likely(now: PointData, given: PointData, pole: Complex, amplitude: Complex) -> PointData:
    """Return forces and noise as they are most likely under a model."""
    likely = with_likely_force(now, given, pole, amplitude)
    return without_ringing(likely, pole, amplitude)


def _completed(
    data: Sequence[PointData], model: ModalModel, doubts: Sequence[Doubts] = ()
) -> tuple[list[PointData], ModalModel]:
    """Add modes one by one, as long as one explains more than chance and the chain do.

    One that rings on from tap to tap is seen by the FRFs only roughly, and moves its neighbours.
    What one promised where it was tried it need not keep: one that would be left out again ends
    the search.
    """
    now, chance = list(data), _chance(data)
    for _ in range(MOST_ADDED):
        more = further_mode(now, model, doubts)
        if more is None:
            break
        fresh, before = now, model
        pole, shape = np.append(model.pole, more[0]), np.vstack([model.shape, more[1]])
        if rings_on(now, pole)[-1] and not doubts:
            fresh, pole = tuned(now, pole)
            shape = first_shapes(free_fit(fresh, pole), model.places)
            before = evaluate(fresh, model.places, model.pole, model.shape)
        least = _least_gain(fresh, before, complex(more[0]), chance, doubts)
        longer = climb(fresh, model.places, pole, shape, doubts=doubts, settled=SETTLED * least)
        if sum(before.cost) - sum(longer.cost) < least:
            break
        now, model = fresh, longer
    return now, model


def _pruned(
    data: Sequence[PointData], model: ModalModel, doubts: Sequence[Doubts] = ()
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
        least = sum(model.cost) + _least_gain(
            data, model, complex(model.pole[weakest]), chance, doubts
        )
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
    data: Sequence[PointData],
    model: ModalModel,
    pole: complex,
    chance: float,
    doubts: Sequence[Doubts] = (),
) -> float:
    """Return the sum of squares that a mode must explain."""
    wrong = inaccuracy(data, np.array([pole]), force_known=bool(doubts))
    return max(1.0, model.misfit) * chance + float(wrong[0])


def _without(
    data: Sequence[PointData],
    model: ModalModel,
    mode: int,
    enough: float,
    doubts: Sequence[Doubts],
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
