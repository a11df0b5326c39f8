"""What the search is steered by: derivatives, the reach of joints, the next experiment."""

import dataclasses

import numpy as np
import pytest

from model_gap.decide.discriminate import experiments_between, separation_now
from model_gap.effects.cubic_stiffness import CubicStiffness
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.payload import Payload
from model_gap.effects.tuned_mass import TunedMass
from model_gap.fit.linearise import tolerance_columns
from model_gap.fit.split import split
from model_gap.fit.thresholds import FIT
from model_gap.search.reach import joint_shares, shares, within_reach
from model_gap.search.search import Search

SEED = 31
SMALL = {'n_fit': 2, 'n_held': 0, 'duration': 8.0}


@pytest.fixture(scope='module')
def search(campaign_of, robot):
    hidden = [{'type': 'cubic_stiffness', 'joint': 'joint_2', 'alpha': 2e6}]
    campaign = campaign_of(hidden, SEED, **SMALL)
    return Search.begin(robot, split(campaign, np.random.default_rng(SEED)))


def test_tolerance_derivatives_are_those_of_the_prediction(search):
    """A step of a twentieth of a deviation bends sharp peaks by a few percent, no more."""
    nominal, predictor = search.nominal, search.data.coarse
    columns = tolerance_columns(nominal, predictor)
    base = predictor.rows(nominal.cell())
    for number in range(0, len(columns), 9):
        values = np.zeros(len(columns))
        values[number] = FIT.tolerance_step
        moved = nominal.moved(values, nominal.inner)
        secant = predictor.rows(moved.cell()) - base
        error = np.linalg.norm(secant / FIT.tolerance_step - columns[number])
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


def test_what_swings_across_all_axes_of_its_link_is_within_reach_there(search):
    """No axis of link 3 alone explains 0.4 of what the best one of another link does."""
    link, predictor = 'link_3', search.data.coarse
    oblique = (10.8, 13.5, 0.04, -0.02, -0.28, 0.24, -0.67, 0.36)
    cell = TunedMass(link, 'y', details=True).apply(search.nominal.cell(), oblique, search.scene)
    rng = np.random.default_rng(SEED)
    records = []
    for item, reading in zip(predictor.records, predictor.predict(cell), strict=True):
        noise = rng.standard_normal((2, *reading.shape))
        noise = np.sqrt(0.5 * item.noise_power) * (noise[0] + 1j * noise[1])
        records.append(dataclasses.replace(item, measured=reading + noise))
    recorded = dataclasses.replace(predictor, records=records)
    swinging = TunedMass.instances(search.scene)
    probes = {}
    for effect in swinging:
        found = effect.probe(search.nominal.cell(), search.scene)
        probes[found[1]] = found
    alone = shares(search.nominal, recorded, probes)
    gains = {name: alone.gain(name) for name in probes}
    own = max(gain for name, gain in gains.items() if name.startswith(f'swing_{link}'))
    assert own < 0.4 * max(gains.values()), f'seed {SEED}: {gains}'
    kept = within_reach(swinging, [search.nominal], recorded, 0.0, 0.4)
    assert link in {effect.location for effect in kept}, f'seed {SEED}: {kept}'


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


def test_held_torques_reproduce_the_prediction(search):
    cell = search.nominal.cell()
    full = CubicStiffness('joint_2').apply(cell, (2e6, 0.0), search.scene)
    held = search.data.coarse.hold(full)
    assert held.forces == ()
    whole, again = (
        search.data.coarse.predict(full),
        search.data.coarse.predict(dataclasses.replace(held)),
    )
    for one, other in zip(whole, again, strict=True):
        assert np.abs(one - other).max() < 1e-9 * np.abs(one).max()
