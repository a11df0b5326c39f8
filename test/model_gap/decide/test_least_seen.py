"""The size from which on an effect would be named is the one from which on it is."""

import dataclasses

import pytest

from model_gap.decide.least_seen import least_seen, LeastSeen
from model_gap.effects import EffectParameter
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.payload import Payload
from model_gap.effects.servo_compliance import ServoCompliance
from model_gap.effects.tuned_mass import TunedMass
from model_gap.fit.fit import fit
from model_gap.report.least_seen_words import least_seen_words
from model_gap.search.run import tolerances_only
from model_gap.search.search import Search, SearchSettings

SEED = 97
SETTINGS = SearchSettings(catalogue=(JointStiffness, TunedMass, ServoCompliance), most_effects=1)


@pytest.fixture(scope='module')
def search(campaign_of, robot):
    campaign = campaign_of((), SEED, n_fit=2, n_held=0, duration=8.0)
    return tolerances_only(Search.begin(robot, campaign, SETTINGS, simulated=True))


@pytest.mark.parametrize(('times', 'named'), [(0.6, False), (1.6, True)])
@pytest.mark.parametrize('kind', ['joint_stiffness', 'tuned_mass'])
def test_what_is_said_is_the_size_from_which_it_is_named(search, kind, times, named):
    """It is added to recordings of a healthy arm; tolerances alone are fitted to these first."""
    found = [item for item in least_seen(search) if item.effect.type == kind]
    said = min(found, key=lambda item: item.scales)
    values = list(said.effect.starts(search.scene)[len(said.effect.starts(search.scene)) // 2])
    values[0] = said.number.value(times * said.number.inner(said.value))
    before, coarse = search.rounds[0].before.hypothesis, search.data.coarse
    cells = [it.cell() for it in (before, before.with_effect(said.effect, tuple(values)))]
    both = [coarse.predict(cell) for cell in cells]
    records = [
        dataclasses.replace(item, measured=item.measured + two - one)
        for item, one, two in zip(coarse.records, *both, strict=True)
    ]
    changed = dataclasses.replace(coarse, records=records)
    without = fit(before, changed)
    added = fit(without.hypothesis.with_effect(said.effect, tuple(values)), changed)
    gain = added.log_evidence - without.log_evidence
    assert (gain >= SETTINGS.worth_adding) == named, f'seed {SEED}: {gain}, {said}'


def test_what_is_small_without_being_nothing_has_no_such_size(search):
    """A servo's frequency; springs and masses have, once for each place."""
    found = least_seen(search)
    assert {item.effect.type for item in found} == {'joint_stiffness', 'tuned_mass'}
    springs = [item.effect.location for item in found if item.effect.type == 'joint_stiffness']
    assert sorted(springs) == sorted(set(springs))


def test_the_best_and_the_worst_place_are_said():
    factor = EffectParameter('factor', '1', 0.7, 0.05, 5.0, neutral=1.0, log=True)
    mass = EffectParameter('mass', 'kg', 10.0, -50.0, 100.0)
    found = [
        LeastSeen(JointStiffness('joint_1'), factor, 0.8),
        LeastSeen(JointStiffness('joint_2'), factor, 1.07),
        LeastSeen(JointStiffness('joint_6'), factor, float('nan')),
        LeastSeen(Payload('flange'), mass, 3.14),
    ]
    assert least_seen_words(found) == [
        'joint stiffness: from factor 1.07 (joint_2) to factor 0.8 (joint_1), '
        'at no plausible size at joint_6',
        'payload: from mass 3.14 kg (flange)',
    ]
    assert least_seen_words([]) == []
