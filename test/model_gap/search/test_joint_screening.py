"""Effects that tolerances all but hide: a few joint steps tell them apart; details when needed."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.errors import ModelError
from model_gap.campaign.read_campaign import read_campaign
from model_gap.effects import CATALOGUE, Scene
from model_gap.effects.base_compliance import BaseCompliance
from model_gap.effects.cable import Cable
from model_gap.effects.effect import Effect, EffectParameter
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.link_flexibility import LinkFlexibility
from model_gap.effects.payload import Payload
from model_gap.effects.places import centre_at_zero, moving_links, turned
from model_gap.effects.tuned_mass import TunedMass
from model_gap.fit.fit import descend, fit, objective
from model_gap.fit.fits import fits
from model_gap.fit.linearise import tolerance_columns
from model_gap.fit.split import split
from model_gap.search.elsewhere import elsewhere
from model_gap.search.joint_screening import screen_jointly
from model_gap.search.refine import fine_fits
from model_gap.search.rivals import fit_instead
from model_gap.search.screen import Projection, screen
from model_gap.search.search import Candidate, Round, Search, SearchSettings
from model_gap.search.steps import fit_tolerances, screen_again, screen_catalogue
from test.model_gap.conftest import ROBOT
from test.support.cell_campaign import cell_campaign
from test.support.hidden_campaign import SENSORS
from test.support.write_campaign import write_campaign

SEED = 47
CABLE_SEED = 503
PLACE = (0.3, 0.05, 0.1)
HIDDEN = {
    'type': 'tuned_mass',
    'link': 'link_4',
    'at': PLACE,
    'axis': (0.0, 0.26, 0.966),
    'mass': 12.0,
    'f': 14.0,
    'zeta': 0.03,
}


@pytest.fixture(scope='module')
def search(campaign_of, robot):
    campaign = campaign_of([HIDDEN], SEED, n_fit=3, n_held=0, duration=12.0)
    return Search.begin(robot, split(campaign, np.random.default_rng(SEED)), simulated=True)


@pytest.mark.slow
def test_swinging_mass_wins_the_race_and_its_place_is_found(search):
    effects = [
        *(TunedMass(link, 'z') for link in ('link_3', 'link_4', 'link_5')),
        *(JointStiffness(joint) for joint in ('joint_3', 'joint_5')),
        LinkFlexibility('link_2', 'y'),
    ]
    base = fit(search.nominal, search.data.loudest).hypothesis
    loudest = search.data.loudest
    trials = screen(
        effects, Projection.of(base, loudest, tolerance_columns(base, loudest)), loudest
    )
    best = screen_jointly(trials, base, loudest)[0]
    assert repr(best.effect) == 'tuned_mass at link_4 z', f'seed {SEED}'
    assert best.gain > 20.0, f'seed {SEED}: {best.gain}'
    start = best.base.with_effect(best.effect, best.values)
    plain = fit(start, search.data.fitting)
    free = fit(plain.hypothesis.with_details(), search.data.fitting, relinearise=2)
    assert free.log_evidence > plain.log_evidence + 10.0, f'seed {SEED}'
    mass, frequency, _, *rest = free.hypothesis.values()[-1]
    assert mass == pytest.approx(12.0, rel=0.05), f'seed {SEED}'
    assert frequency == pytest.approx(14.0, rel=0.01), f'seed {SEED}'
    assert rest[:3] == pytest.approx(PLACE, abs=0.06), f'seed {SEED}'
    assert turned('z', rest[3:]) == pytest.approx(HIDDEN['axis'], abs=0.1), f'seed {SEED}'


def test_from_another_link_the_right_one_is_found(search):
    """A fit on the wrong link leads to all others, and there to a better one."""
    predictor = search.data.loudest
    start = search.nominal.with_effect(TunedMass('link_5', 'z'), (8.0, 14.0, 0.04))
    columns = tolerance_columns(search.nominal, predictor)
    wrong = descend(start.with_details(), predictor, columns, 4).hypothesis

    def value(hypothesis):
        rows = predictor.rows(hypothesis.cell())
        return objective(predictor.weighting.misfit(rows), hypothesis)

    nothing = search.nominal
    placed = elsewhere(wrong, nothing, predictor)
    found = {item.effects[-1].location: value(item) for item in placed}
    # One that is far behind is not told at all.
    beside = found.get('link_6', np.inf)
    assert found['link_4'] < min(value(wrong), beside) - 40.0, f'seed {SEED}: {found}'
    base = search.nominal.with_effect(BaseCompliance(), (1e-8,) * 2)
    assert elsewhere(base, nothing, predictor) == [], 'it has no other place'


def test_another_axis_of_its_own_link_is_another_place(search):
    """Turned as far as it may be it does not come to where it swings; another axis does."""
    predictor = search.data.loudest
    values = (12.0, 14.0, 0.03, *PLACE, 0.0, 1.2)
    wrong = search.nominal.with_effect(TunedMass('link_4', 'x', details=True), values)
    placed = elsewhere(wrong, search.nominal, predictor)
    (found,) = (item for item in placed if item.effects[-1].location == 'link_4')
    assert found.effects[-1].variant != 'x', f'seed {SEED}'
    axis = turned(found.effects[-1].variant, found.values()[-1][6:])
    assert abs(np.array(axis) @ HIDDEN['axis']) > 0.97, f'seed {SEED}: {axis}'


@pytest.mark.slow
def test_a_swinging_mass_is_followed_over_two_links(search):
    """The next link is better, and only from there its own comes in sight."""
    start = search.nominal.with_effect(TunedMass('link_2', 'x'), (2.0, 14.0, 0.04))
    far = fit(start, search.data.fitting, relinearise=2)
    nothing = fit(search.nominal, search.data.fitting)
    ways = fine_fits(replace(search, current=nothing, fits=(far,)))
    assert ways[0].hypothesis.effects[-1].key == ('tuned_mass', 'link_4'), f'seed {SEED}: {ways}'
    assert ways[0].log_evidence > far.log_evidence + 10.0, f'seed {SEED}'


def test_details_left_alone_change_nothing(search):
    found = 0
    for kind in CATALOGUE:
        effect = kind.instances(search.scene)[0]
        if effect.detailed() is None:
            continue
        found += 1
        values = tuple(effect.starts(search.scene)[0])
        plain = search.nominal.with_effect(effect, values)
        free = plain.with_details()
        assert len(free.inner) > len(plain.inner)
        assert free.with_details() is None
        one, other = (search.data.loudest.predict(item.cell())[0] for item in (plain, free))
        assert np.abs(one - other).max() < 1e-9 * np.abs(one).max(), effect
    assert found >= 4


def test_places(search):
    scene: Scene = search.scene
    links = moving_links(scene)
    assert len(links) == len(scene.model.joint_names)
    assert set(links) <= set(scene.model.link_names)
    assert turned('x', (0.0, 0.0)) == (1.0, 0.0, 0.0)
    assert turned('y', (0.0, np.pi / 4)) == pytest.approx((0.5**0.5, 0.5**0.5, 0.0))


@pytest.mark.slow
def test_another_place_is_tried_beside_all_that_was_found(search):
    """The swinging mass on the next link, a softer drive beside it."""
    fitting, softer = search.data.fitting, JointStiffness('joint_2')
    right = search.nominal.with_effect(TunedMass('link_4', 'z'), (12.0, 14.0, 0.03))
    final = fit(right.with_effect(softer, (1.0,)), fitting, relinearise=2)
    wrong = search.nominal.with_effect(TunedMass('link_5', 'z'), (8.0, 14.0, 0.04))
    alone = fit(wrong, fitting, relinearise=0)
    begun = replace(search, rounds=(Round(alone, 1.0, (), ()),))
    other = Candidate(wrong.effects[0], alone, 0.0, 1.0)
    found = fit_instead(begun, final, right.effects[0], other)
    assert [item.key for item in found.fit.hypothesis.effects] == [
        softer.key, wrong.effects[0].key
    ]  # fmt: skip
    assert found.fit.log_evidence < final.log_evidence - 8.0, f'seed {SEED}'
    assert found.fit.log_evidence >= alone.log_evidence - 10.0, f'seed {SEED}'


def test_a_load_stays_as_uncertain_as_the_mass_beside_it(search):
    """With the derivatives of a point near by, tolerance and load must still look alike."""
    predictor, flange = search.data.loudest, Payload(search.model.link_names[-1])
    start = search.nominal.with_effect(flange, (5.0, 0.0, 0.0, 0.0, 0.06))
    found = fit(start, predictor, relinearise=8)
    assert found.linearised is not None, f'seed {SEED}'
    rng = np.random.default_rng(SEED)
    values = found.hypothesis.tolerance_values
    away = found.hypothesis.moved(
        values + 0.02 * rng.standard_normal(len(values)), found.hypothesis.inner
    )
    again = fit(away, predictor, found.linearised, iterations=0)
    assert again.linearised is found.linearised, f'seed {SEED}'
    expected = np.sqrt(np.diag(found.covariance))
    assert np.sqrt(np.diag(again.covariance)) == pytest.approx(expected, rel=0.05), f'seed {SEED}'


def test_an_arm_that_is_not_possible_is_left_out(search):
    """A load that weighs less than nothing by more than the arm has: no end of the search."""
    predictor = search.data.loudest
    flange = Payload(search.model.link_names[-1])
    starts = [
        search.nominal.with_effect(flange, (mass, 0.0, 0.0, 0.0, 0.06)) for mass in (2.0, -1e5)
    ]
    with pytest.raises(ModelError):
        predictor.rows(starts[1].cell())
    possible, impossible = fits(lambda start: fit(start, predictor, relinearise=0), starts)
    assert impossible is None
    assert [effect.key for effect in possible.hypothesis.effects] == [flange.key]


class Endless(Effect):
    """What the sensors read grows beyond all numbers."""

    type = 'endless'

    @classmethod
    def instances(cls, scene):
        return [cls()]

    def parameters(self, scene):
        return (EffectParameter('factor', '1', 1.0, 0.0, 2.0, neutral=1.0),)

    def apply(self, cell, values, scene):
        return cell.then_output(lambda omega, spectra: np.full_like(spectra, np.inf))


def test_a_start_whose_response_is_endless_is_left_out(search):
    """Steps from there lead to numbers that are none."""
    predictor = search.data.loudest
    start = search.nominal.with_effect(Endless(), (1.0,))
    with np.errstate(invalid='ignore', over='ignore'):
        found = fits(lambda it: fit(it, predictor, relinearise=0), [start])
    assert found == [None]


@pytest.mark.slow
def test_a_cable_is_found_that_pulls_the_wrong_way_from_where_it_is_sought(robot, tmp_path):
    """Two steps of a fit from any side make it worse, seven turn it to where it comes from."""
    cable = {'kind': 'cable', 'link': 'link_4', 'at': (0.4, 0.0, 0.1), 'anchor': (0.5, 1.5, 3.0)}
    records = cell_campaign(
        ROBOT, CABLE_SEED, {**cable, 'k': 3e4}, n_fit=3, n_held=1, duration=12.0
    )
    write_campaign(tmp_path, records, robot.joint_names, SENSORS)
    settings = SearchSettings(catalogue=(Cable, JointStiffness))
    campaign = split(read_campaign(tmp_path, robot), np.random.default_rng(0))
    search = fit_tolerances(Search.begin(robot, campaign, settings))
    search = screen_again(screen_catalogue(search))
    best = search.trials[0]
    assert best.effect.key == ('cable', 'link_4'), f'seed {CABLE_SEED}: {search.trials[:3]}'
    assert best.gain > 20.0, f'seed {CABLE_SEED}: {best}'
    at = np.array(best.effect.anchor(best.values, search.scene))
    way = at - centre_at_zero(search.scene, 'link_4')
    assert way[2] > 0.5 * np.linalg.norm(way), f'seed {CABLE_SEED}: it comes from above'
