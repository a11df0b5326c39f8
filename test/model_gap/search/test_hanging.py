"""A swinging mass far from its link's centre of mass is begun where it would explain most."""

import numpy as np
import pytest

from model_gap.effects import Scene
from model_gap.effects.places import centre
from model_gap.effects.tuned_mass import TunedMass
from model_gap.fit.split import split
from model_gap.search.search import Search, SearchSettings
from model_gap.search.steps import fit_tolerances, screen_again, screen_catalogue, seek_hanging

SEED = 73
# Beyond the joint's axis, seen from the link's centre of mass.
POINT, AXIS = (0.3, 0.1, -0.05), (0.0, 0.3, 0.954)
HIDDEN = {
    'type': 'tuned_mass',
    'link': 'link_3',
    'at': POINT,
    'axis': AXIS,
    'mass': 14.0,
    'f': 17.0,
    'zeta': 0.05,
}


@pytest.fixture(scope='module')
def fitted(campaign_of, robot):
    campaign = campaign_of([HIDDEN], SEED, n_fit=3, n_held=0, duration=12.0)
    settings = SearchSettings(catalogue=(TunedMass,))
    divided = split(campaign, np.random.default_rng(SEED))
    return fit_tolerances(Search.begin(robot, divided, settings, simulated=True))


@pytest.mark.slow
def test_its_link_and_frequency_are_found(fitted):
    """From the centres of mass another link's explains most, and less."""
    found = screen_again(screen_catalogue(seek_hanging(fitted))).trials[0]
    assert found.effect.key == ('tuned_mass', 'link_3'), f'seed {SEED}: {found}'
    at_centre = screen_again(screen_catalogue(fitted)).trials[0]
    assert found.gain > at_centre.gain + 10.0, f'seed {SEED}: {found.gain}, {at_centre.gain}'
    assert found.values[1] == pytest.approx(17.0, rel=0.05), f'seed {SEED}: {found}'


def test_every_link_and_axis_has_its_places(fitted):
    scene: Scene = seek_hanging(fitted).scene
    effects = TunedMass.instances(scene)
    assert all(effect.details for effect in effects)
    for effect in effects:
        starts = effect.starts(scene)
        assert len(starts) == 2 and len({start[3:6] for start in starts}) == 2, effect
        for start in starts:
            away = np.subtract(start[3:6], centre(scene, effect.location))
            assert np.count_nonzero(np.abs(away) > 1e-9) <= 1, 'along one axis of its link'


def test_where_nothing_was_sought_it_begins_at_the_centre(fitted):
    effect = TunedMass.instances(fitted.scene)[0]
    assert not effect.details
    plain, free = effect.starts(fitted.scene)[0], effect.detailed().starts(fitted.scene)[0]
    assert free[:3] == plain
    assert free[3:6] == centre(fitted.scene, effect.location)
