"""A mass that hangs at a point of a link: the arm's own response there tells what it does."""

import numpy as np
import pytest

from model_gap.effects.places import turned
from model_gap.effects.tuned_mass import TunedMass
from model_gap.fit.split import split
from model_gap.predict.hung import at_point, hung, link_motions
from model_gap.search.search import Search

SEED = 71
MASS, FREQUENCY, DAMPING = 15.0, 14.0, 0.06
POINT, TURNS = (0.3, -0.2, 0.1), (0.3, -0.4)


@pytest.fixture(scope='module')
def search(campaign_of, robot):
    campaign = campaign_of((), SEED, n_fit=2, n_held=0, duration=8.0)
    return Search.begin(robot, split(campaign, np.random.default_rng(SEED)), simulated=True)


def test_change_is_that_of_an_arm_with_the_mass_built_in(search):
    """But for what rings on when a record ends, at the sharpest peaks."""
    predictor, bare = search.data.coarse, search.nominal
    effect = TunedMass('link_4', 'z', details=True)
    values = (MASS, FREQUENCY, DAMPING, *POINT, *TURNS)
    built = predictor.predict(bare.with_effect(effect, values).cell())
    without = predictor.predict(bare.cell())
    motions = link_motions(bare.cell(), predictor, 'link_4')
    for way, least, most in ((turned('z', TURNS), 0.0, 0.1), (turned('x', (0.0, 0.0)), 0.4, 9.0)):
        errors = []
        for motion, item, one, other in zip(
            motions, predictor.records, built, without, strict=True
        ):
            point = motion.through(at_point(POINT))
            frequencies = np.array([9.0, FREQUENCY])
            found = hung(point, item.omega[:, 1], MASS, np.array(way), frequencies, DAMPING)[1]
            change = one - other
            errors += list(np.linalg.norm(found - change, axis=0) / np.linalg.norm(change, axis=0))
        assert least <= np.median(errors) < most, f'seed {SEED}: {np.quantile(errors, [0.5, 0.9])}'
