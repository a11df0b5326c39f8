"""A hard spring that gravity loads: far from the model, and found."""

import pytest

from model_gap.effects import CubicStiffness
from model_gap.search import Search, SearchSettings
from model_gap.search.steps import fit_roughly, fit_tolerances, screen_catalogue

SEED = 31
ALPHA = 1.3e6
HIDDEN = {'type': 'cubic_stiffness', 'joint': 'joint_3', 'alpha': ALPHA, 'preload': 1.0}
ALONE = SearchSettings(catalogue=(CubicStiffness,), most_effects=1)


@pytest.mark.slow
def test_a_spring_twice_as_stiff_under_its_load_is_found_roughly(campaign_of, robot):
    """More load on a softer spring stiffens it alike, but for how it moves with amplitude."""
    campaign = campaign_of([HIDDEN], SEED, n_held=0)
    search = fit_tolerances(Search.begin(robot, campaign, ALONE, simulated=True))
    found = fit_roughly(screen_catalogue(search)).fits[0]
    (values,) = found.hypothesis.values()
    assert found.hypothesis.effects[-1].location == 'joint_3', f'seed {SEED}: {found.hypothesis}'
    assert found.misfit < 1.5, f'seed {SEED}: {found.misfit:.3g} at {values}'
    assert values == pytest.approx((ALPHA, 1.0), rel=0.15), f'seed {SEED}: {values}'
