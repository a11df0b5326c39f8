"""What the search is steered by: derivatives, the reach of joints, the next experiment."""

import dataclasses

import numpy as np
import pytest

from model_gap.discriminate import experiments_between, separation_now
from model_gap.effects.cubic_stiffness import CubicStiffness
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.payload import Payload
from model_gap.joint_law import FrictionLaw
from model_gap.linearise import tolerance_columns, TOLERANCE_STEP
from model_gap.reach import joint_shares, within_reach
from model_gap.search import Search
from model_gap.split import split

SEED = 31
SMALL = {'n_fit': 2, 'n_held': 0, 'duration': 8.0}


@pytest.fixture(scope='module')
def search(campaign_of, robot):
    hidden = [{'type': 'cubic_stiffness', 'joint': 'joint_2', 'alpha': 2e6}]
    campaign = campaign_of(hidden, SEED, **SMALL)
    return Search(robot, split(campaign, np.random.default_rng(SEED)))


def test_tolerance_derivatives_are_those_of_the_prediction(search):
    """A step of a twentieth of a deviation bends sharp peaks by a few percent, no more."""
    nominal, predictor = search.nominal, search.data.coarse
    columns = tolerance_columns(nominal, predictor)
    base = predictor.rows(nominal.setup())
    for number in range(0, len(columns), 9):
        values = np.zeros(len(columns))
        values[number] = TOLERANCE_STEP
        moved = nominal.moved(values, nominal.inner)
        secant = predictor.rows(moved.setup()) - base
        error = np.linalg.norm(secant / TOLERANCE_STEP - columns[number])
        name = nominal.tolerances[number].name
        assert error < 0.08 * np.linalg.norm(columns[number]), name


def test_hidden_torque_is_within_reach_of_its_joint_alone(search):
    found = joint_shares(search.nominal, search.data.coarse)
    best = max(found.explained, key=lambda place: found.explained[place])
    assert best == 'joint_2', f'seed {SEED}: {found.explained}'
    assert found.explained['joint_2'] > 0.8 * found.total
    candidates = [JointStiffness(f'joint_{number}') for number in (2, 6)]
    kept = within_reach(candidates, [search.nominal], search.data.coarse, 3.0, 0.3)
    assert [effect.location for effect in kept] == ['joint_2'], f'seed {SEED}'


def test_next_experiment_separates_better_than_the_campaign(search):
    one = search.nominal.with_effect(JointStiffness('joint_2'), (0.9,))
    other = search.nominal.with_effect(Payload('flange'), (20.0, 0.0, 0.0, 0.0, 0.06))
    found = experiments_between(one, other, search.data.coarse, np.random.default_rng(SEED))
    assert len(found) > 10
    assert found[0].separation > separation_now(one, other, search.data.coarse)
    separations = [item.separation for item in found]
    assert separations == sorted(separations, reverse=True)
    same = experiments_between(one, one, search.data.coarse, np.random.default_rng(SEED))
    assert max(item.separation for item in same) == 0.0


def test_mean_friction_over_a_step_is_the_integral_of_the_law(rng):
    """The speed runs straight from -v to v' in one step: the torque's mean is known."""
    start, end = -rng.uniform(1e-3, 1e-1, 50), rng.uniform(1e-3, 1e-1, 50)
    level, width = np.full(50, 30.0), np.full(50, 2e-3)
    nothing = np.zeros(50)
    law = FrictionLaw(
        np.array([level, width, nothing]), np.ones(50), nothing, nothing, nothing, 1 / 600
    )
    ends = [law.torque(nothing, speed, nothing) for speed in (start, end)]
    mean = 0.5 * (ends[0] + ends[1]) + law.surplus()
    fine = start + (end - start) * (np.arange(20000)[:, None] + 0.5) / 20000
    expected = np.mean(30.0 * np.tanh(fine / 2e-3), axis=0)
    assert mean == pytest.approx(expected, abs=1e-3)


def test_friction_solves_its_implicit_equation(rng):
    """Torque and the speed it leaves belong together, from stuck to sliding."""
    level, width = rng.uniform(10.0, 300.0, 400), 10.0 ** rng.uniform(-4.0, -2.0, 400)
    give = 10.0 ** rng.uniform(-7.0, -4.0, 400)
    nothing = np.zeros(400)
    values = np.array([level, width, nothing])
    law = FrictionLaw(values, np.ones(400), nothing, nothing, give, 1 / 600)
    rate = rng.standard_normal(400) * 10.0 ** rng.uniform(-4.0, 0.0, 400)
    torque = law.torque(nothing, rate, nothing)
    expected = level * np.tanh((rate - give * torque) / width)
    left = rate - give * torque
    # An error of the torque changes the speed it leaves: judged where both meet.
    slope = 1.0 + give * level / width * (1.0 - np.tanh(left / width) ** 2)
    assert np.abs((torque - expected) / slope / level).max() < 0.01


def test_held_torques_reproduce_the_prediction(search):
    setup = search.nominal.setup()
    full = CubicStiffness('joint_2').apply(setup, (2e6, 0.0), search.scene)
    held = search.data.coarse.hold(full)
    assert held.forces == ()
    whole, again = (
        search.data.coarse.predict(full),
        search.data.coarse.predict(dataclasses.replace(held)),
    )
    for one, other in zip(whole, again, strict=True):
        assert np.abs(one - other).max() < 1e-9 * np.abs(one).max()
