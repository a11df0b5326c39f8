"""What tolerances far off nominal stand for is found from where they stood before."""

import pytest

from model_gap.effects import TunedMass
from model_gap.hypothesis import instead_of_tolerances, stretch, STRETCHED
from model_gap.search import fit_tolerances, Search, SearchSettings
from model_gap.search.steps import fit_roughly, screen_catalogue

SEED = 32
MASS, FREQUENCY = 21.5, 27.8
# It hangs 0.27 m from the link's centre.
HIDDEN = {
    'type': 'tuned_mass',
    'link': 'link_3',
    'at': (0.2, 0.0, 0.1),
    'axis': (0.0, 1.0, 0.0),
    'mass': MASS,
    'f': FREQUENCY,
    'zeta': 0.09,
}
ALONE = SearchSettings(catalogue=(TunedMass,), most_effects=1)


@pytest.fixture(scope='module')
def fitted(campaign_of, robot):
    campaign = campaign_of([HIDDEN], SEED, n_held=0)
    return fit_tolerances(Search.begin(robot, campaign, ALONE, simulated=True))


def test_a_link_s_mass_far_off_may_swing_on_that_link(fitted):
    hypothesis = fitted.fitted.hypothesis
    far = {
        item.link
        for item, value in zip(hypothesis.tolerances, hypothesis.tolerance_values, strict=True)
        if abs(value) > STRETCHED and item.what == 'mass'
    }
    starts = instead_of_tolerances(hypothesis, fitted.unstretched, ALONE.catalogue)
    assert stretch(hypothesis) > STRETCHED and far, f'seed {SEED}'
    assert {start.effects[-1].location for start in starts} == far, f'seed {SEED}'
    assert all(not start.tolerance_values.any() for start in starts)


@pytest.mark.slow
def test_a_swinging_mass_is_found_where_it_hangs(fitted):
    """From the link's centre, its place free from the first step on."""
    found = fit_roughly(screen_catalogue(fitted)).fits[0].hypothesis
    (effect,), (values,) = found.effects, found.values()
    assert effect.location == 'link_3', f'seed {SEED}: {effect}'
    assert values[:2] == pytest.approx((MASS, FREQUENCY), rel=0.1), f'seed {SEED}: {values}'
    assert values[3:6] == pytest.approx(HIDDEN['at'], abs=0.06), f'seed {SEED}: {values}'
