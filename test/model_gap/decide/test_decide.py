"""When numbers that fit are not believed: at the end of what is plausible, or two for one law."""

from dataclasses import replace

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.cell.cell_model import CellModel
from model_gap.cell.tolerances import nuisances, Tolerances
from model_gap.decide.adequacy import Adequacy, BandLevel
from model_gap.decide.decide import (
    AGREEING,
    at_ends,
    at_limits,
    at_other_ends,
    half_explained,
    objections,
    one_law,
)
from model_gap.effects import Scene
from model_gap.effects.backlash import Backlash
from model_gap.effects.cable import Cable
from model_gap.effects.coulomb_friction import CoulombFriction
from model_gap.effects.gravity_compensator import GravityCompensator
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.payload import Payload
from model_gap.effects.sensor_polarity import SensorPolarity
from model_gap.effects.tuned_mass import TunedMass
from model_gap.fit.fit import Fit
from model_gap.hypothesis.hypothesis import Hypothesis
from model_gap.search.rivals import confirmed, rivals_of
from model_gap.search.search import Candidate, Round, SearchSettings


@pytest.fixture(scope='module')
def nominal(robot, layout):
    cell = CellModel(explicit_damping(robot.spec), layout.channels)
    names = tuple(sensor.name for sensor in layout)
    return Hypothesis(Scene(robot, names, cell), (), (), np.zeros(0), np.zeros(0))


def test_a_number_at_the_end_of_its_range_is_no_explanation(nominal):
    stop = nominal.with_effect(JointStiffness('joint_2'), (5.0,))
    (reason,) = at_limits(stop)
    assert 'factor of joint_stiffness at joint_2' in reason
    assert at_limits(nominal.with_effect(JointStiffness('joint_2'), (4.9,))) == ()
    # Details may be nothing at all, and some effects have no number.
    held = nominal.with_effect(Backlash('joint_2'), (1e-4, 0.0))
    assert at_limits(held) == ()
    assert at_limits(nominal.with_effect(SensorPolarity('sensor:elbow', 'x'), ())) == ()


def test_every_size_of_an_effect_has_an_end(nominal):
    """A counterbalance has two, a payload one: its centre of mass is none."""
    half = GravityCompensator('joint_2')
    _, across = half.parameters(nominal.scene)
    (reason,) = at_limits(nominal.with_effect(half, (0.0, across.high)))
    assert 'strength_sin' in reason
    payload = Payload(nominal.scene.model.link_names[-1])
    start = payload.starts(nominal.scene)[0]
    _, along, *_ = payload.parameters(nominal.scene)
    aside = nominal.with_effect(payload, (start[0], along.high, *start[2:]))
    assert at_limits(aside) == ()
    (reason,) = at_other_ends(aside)
    assert 'com x' in reason


@pytest.mark.parametrize(('frequency', 'reasons'), [(70.0, 1), (69.0, 0), (2.0, 1), (2.1, 0)])
def test_what_swings_as_fast_or_slowly_as_it_may_can_be_something_else(
    nominal, frequency, reasons
):
    link = nominal.scene.model.link_names[-1]
    swings = nominal.with_effect(TunedMass(link, 'x'), (10.0, frequency, 0.04))
    assert len(at_other_ends(swings)) == reasons
    assert at_limits(swings) == ()


def test_small_numbers_of_a_wide_range_are_at_no_end(nominal):
    """From 0.02 mrad/s to 0.1 rad/s: 0.1 mrad/s is far from both."""
    friction = CoulombFriction('joint_2')
    few = nominal.with_effect(
        friction, (100.0, 1e-4, 0.0)[: len(friction.parameters(nominal.scene))]
    )
    assert at_other_ends(few) == ()


def test_play_and_another_stiffness_in_one_joint_may_be_one_law(nominal):
    play = nominal.with_effect(Backlash('joint_2'), (1e-4, 0.2))
    assert one_law(play) == ()
    (reason,) = one_law(play.with_effect(JointStiffness('joint_2'), (3.0,)))
    assert 'backlash at joint_2 and joint_stiffness' in reason
    assert one_law(play.with_effect(JointStiffness('joint_3'), (3.0,))) == ()
    softer = nominal.with_effect(JointStiffness('joint_2'), (0.8,))
    link = nominal.scene.model.link_names[-1]
    values = tuple(Payload(link).starts(nominal.scene)[0])
    assert one_law(softer.with_effect(Payload(link), values)) == ()


def rounds(nominal, *steps):
    """Return rounds that found (effect, gain, held-out misfit) and others like it."""
    found, fitted, held = [], fit_of(nominal), 100.0
    for effects in steps:
        candidates = []
        for effect, gain, misfit in effects:
            values = tuple(effect.starts(nominal.scene)[0])
            added = fit_of(fitted.hypothesis.with_effect(effect, values))
            candidates.append(Candidate(effect, added, gain, misfit))
        found.append(Round(fitted, held, tuple(candidates), ()))
        fitted, held = candidates[0].fit, candidates[0].heldout_misfit
    return found


def fit_of(hypothesis):
    return Fit(hypothesis, 1.0, 0.0, np.zeros((0, 0)), np.zeros((0, 0)))


WORTH_ADDING = SearchSettings().worth_adding
SOFTER, OTHER = JointStiffness('joint_2'), JointStiffness('joint_3')
PLAY = Backlash('joint_2')


def no_fit(*_):
    raise AssertionError('nothing is to be fitted')


def as_it_was(final, best, other):
    return other


def rivals(done, instead):
    return rivals_of(done, kept(done), instead, lambda fitted: fitted.log_evidence)


def kept(found):
    return confirmed(found, WORTH_ADDING)


def names_of(pairs):
    return [(pair.accepted.effect, pair.rival.effect) for pair in pairs]


def test_an_effect_that_was_added_later_is_no_rival(nominal):
    done = rounds(nominal, [(SOFTER, 449.0, 10.0), (OTHER, 448.0, 12.0)], [(OTHER, 300.0, 1.0)])
    accepted = kept(done)
    assert [item.effect for item in accepted] == [SOFTER, OTHER]
    assert rivals(done, no_fit) == ()
    alone = rounds(nominal, [(SOFTER, 449.0, 10.0), (OTHER, 448.0, 12.0)])
    assert names_of(rivals(alone, as_it_was)) == [(SOFTER, OTHER)]


def test_a_rival_is_judged_by_a_fit_that_was_taken_to_its_end(nominal):
    """What stopped short may look 20 units worse than it is; what is far behind is left."""
    done = rounds(nominal, [(SOFTER, 449.0, 10.0), (OTHER, 429.0, 12.0)])
    assert names_of(rivals(done, as_it_was)) == [(SOFTER, OTHER)]
    far = rounds(nominal, [(SOFTER, 449.0, 10.0), (OTHER, 424.0, 12.0)])
    assert rivals(far, no_fit) == ()


@pytest.mark.parametrize(('behind', 'remains'), [(7.0, True), (9.0, False)])
def test_a_rival_of_an_early_round_is_judged_beside_all_that_was_found(nominal, behind, remains):
    done = rounds(nominal, [(SOFTER, 449.0, 10.0), (PLAY, 446.0, 12.0)], [(OTHER, 300.0, 1.0)])
    accepted = kept(done)
    final = accepted[-1].fit

    def instead(whole, best, other):
        assert (whole, best, other.effect) == (final, SOFTER, PLAY)
        return replace(other, fit=replace(other.fit, log_evidence=whole.log_evidence - behind))

    found = rivals(done, instead)
    assert names_of(found) == ([(SOFTER, PLAY)] if remains else [])
    assert rivals(done, lambda *_: None) == ()  # not a possible arm


def test_rivals_are_those_of_the_same_round(nominal):
    # The first round alone is worse on held-out recordings; with the second it is right.
    done = rounds(
        nominal,
        [(SOFTER, 50.0, 110.0), (PLAY, 20.0, 100.0)],
        [(OTHER, 300.0, 1.0), (PLAY, 298.0, 1.0)],
    )
    accepted = kept(done)
    assert [item.effect for item in accepted] == [SOFTER, OTHER]
    assert names_of(rivals(done, as_it_was)) == [(OTHER, PLAY)]


def test_what_worsens_held_out_recordings_is_not_confirmed(nominal):
    assert kept(rounds(nominal, [(SOFTER, 50.0, 110.0)])) == ()
    both = rounds(nominal, [(SOFTER, 50.0, 110.0)], [(OTHER, 50.0, 105.0)])
    assert kept(both) == ()
    first = rounds(nominal, [(SOFTER, 50.0, 10.0)], [(OTHER, 50.0, 12.0)])
    assert [item.effect for item in kept(first)] == [SOFTER]


def test_a_tolerance_stretched_far_predicts_no_better_than_it_may(nominal):
    """As a turned sensor does: the tolerance of its mount predicts as well, at 15 deviations."""
    (first,) = rounds(nominal, [(SOFTER, 170.0, 104.0)])
    assert kept([first]) == ()
    tolerances = nuisances(nominal.scene.cell, ('link_3',), Tolerances())[:1]
    for deviations, confirmed_effects in ((15.0, [SOFTER]), (1.0, [])):
        stretched = replace(
            nominal, tolerances=tolerances, tolerance_values=np.array([deviations])
        )
        # A precision of many data: they tell the tolerance.
        before = replace(fit_of(stretched), precision=np.full((1, 1), 100.0))
        found = kept([replace(first, before=before)])
        assert [item.effect for item in found] == confirmed_effects


def test_what_explains_only_the_fitted_poses_is_told_as_that(nominal):
    (found,) = rounds(nominal, [(Cable('link_4'), 688.0, 168.0)])
    (told,) = half_explained(found, WORTH_ADDING)
    assert told.startswith('cable at link_4 explains the fitted poses (1 times the noise')
    assert 'not the held-out ones (13, ' in told
    (other,) = rounds(nominal, [(Cable('link_4'), 5.0, 168.0)])
    assert half_explained(other, WORTH_ADDING) == ()


def test_a_model_that_misses_heldout_recordings_by_little_does_not_agree_with_them():
    """A swinging mass taken for tolerances leaves 1.09 times the noise there; a name may."""
    here = BandLevel('12-18 Hz at level 0', 1.2, 500)
    left = Adequacy(1.01, 1.19, here, here, 2.9, 'mass of link_3', 8000, 8000)
    (why,) = objections(left, AGREEING)
    assert why == '1.09 times the noise remains in held-out recordings'
    assert objections(left) == objections(left.of_fitted, AGREEING) == ()
    # Of fewer data that much is chance.
    assert objections(replace(left, count_heldout=200), AGREEING) == ()
    band = replace(left, heldout=1.02, worst_heldout=replace(here, misfit=1.5))
    (why,) = objections(band, AGREEING)
    assert why == '1.22 times the noise remains at 12-18 Hz at level 0 in held-out recordings'


def test_a_cable_at_the_end_of_its_range_is_told_so(nominal):
    cable = Cable('link_4')
    items = cable.parameters(nominal.scene)
    values = (1e3, 0.5, 0.3, items[3].low)
    (told,) = at_ends(nominal.with_effect(cable, values))
    assert told.startswith('nearness of cable at link_4 is at the end of its range, -')
    assert at_ends(nominal.with_effect(cable, (0.0, 0.5, 0.5, 0.3))) == ()
