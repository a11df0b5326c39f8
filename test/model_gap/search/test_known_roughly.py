"""A model of which every spring and damper is a guess: the first fit finds the arm."""

import dataclasses

import numpy as np
import pytest

from model_gap.cell.tolerances import Tolerances
from model_gap.search import Search, SearchSettings
from model_gap.search.steps import fit_tolerances
from structural_model.description import Spring

SEEDS = (31, 32, 33)


def guessed(model, rng):
    """Return a model whose springs and dampers are wrong by up to 40 %, each by its own."""

    def wrong(spring):
        if spring.rigid:
            return spring
        factor = 1.0 + rng.uniform(-0.4, 0.4)
        return Spring(spring.stiffness * factor, spring.damping * factor)

    joints = tuple(
        dataclasses.replace(
            item,
            drive=dataclasses.replace(item.drive, spring=wrong(item.drive.spring)),
            tilts=tuple(map(wrong, item.tilts)),
        )
        for item in model.spec.joints
    )
    return model.replace(dataclasses.replace(model.spec, joints=joints))


@pytest.mark.slow
@pytest.mark.parametrize('seed', SEEDS)
def test_the_first_fit_finds_springs_that_are_far_off(seed, robot, campaign_of):
    """Were dampers known to 10 %, it would rest in an arm with other peaks: misfits above 1000."""
    campaign = campaign_of((), seed, duration=10.0)
    model = guessed(robot, np.random.default_rng(seed))
    settings = SearchSettings(tolerances=Tolerances(stiffness=0.4))
    search = fit_tolerances(Search.begin(model, campaign, settings))
    assert search.current.misfit < 1.3, f'seed {seed}'
    found = {
        item.name: item.sigma * value
        for item, value in zip(
            search.tolerances, search.current.hypothesis.tolerance_values, strict=True
        )
    }
    drives = [f'stiffness of {item.name}' for item in model.spec.joints]
    wrong = [
        new.drive.spring.stiffness / old.drive.spring.stiffness
        for new, old in zip(model.spec.joints, robot.spec.joints, strict=True)
    ]
    off = [found[name] + np.log(factor) for name, factor in zip(drives, wrong, strict=True)]
    # The last axis carries little: this campaign does not tell its spring.
    assert np.abs(off[:5]).max() < 0.1, f'seed {seed}: {off}'


def test_what_is_known_well_is_not_fitted_first(robot, campaign_of):
    campaign = campaign_of((), 30, n_fit=1, n_held=0, duration=6.0, levels=(1.0,))
    search = Search.begin(robot, campaign)
    assert search.rough_places == ()
    by_name = SearchSettings(tolerances=Tolerances(by_name={'stiffness of joint_2': 0.3}))
    search = Search.begin(robot, campaign, by_name)
    names = [search.tolerances[place].name for place in search.rough_places]
    assert names == ['stiffness of joint_2', 'damping of joint_2']
    gains = SearchSettings(tolerances=Tolerances(gain=0.3))
    assert Search.begin(robot, campaign, gains).rough_places == ()
