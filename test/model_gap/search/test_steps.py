"""The steps of a search: a state in, another out, with reasons in the log."""

import dataclasses
import logging
import re

import numpy as np
import pytest

from model_gap.decide import decide
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.sensor_gain import SensorGain
from model_gap.hypothesis import stretch, STRETCHED
from model_gap.search import run_search, Search, SearchSettings
from model_gap.search.steps import fit_tolerances, screen_catalogue

SEED = 21
HIDDEN = {'type': 'joint_stiffness', 'joint': 'joint_2', 'factor': 0.7}
FEWEST = SearchSettings(catalogue=(JointStiffness, SensorGain), most_effects=1)


@pytest.fixture(scope='module')
def begun(campaign_of, robot):
    campaign = campaign_of([HIDDEN], SEED, n_fit=1, n_held=1, duration=8.0)
    return Search.begin(robot, campaign, FEWEST, simulated=True)


def test_a_step_leaves_its_state_as_it_was_and_says_the_same_again(begun):
    """Whatever was asked of the data in between: nothing is remembered but in the state."""
    first = screen_catalogue(fit_tolerances(begun))
    softer = begun.nominal.with_effect(JointStiffness('joint_2'), (0.5,))
    begun.heldout_misfit(softer)
    again = screen_catalogue(fit_tolerances(begun))
    assert begun.current is None and begun.trials == () and begun.rounds == ()
    np.testing.assert_array_equal(
        first.current.hypothesis.tolerance_values, again.current.hypothesis.tolerance_values
    )
    assert [(repr(one.effect), one.gain) for one in first.trials] == [
        (repr(one.effect), one.gain) for one in again.trials
    ]
    with pytest.raises(dataclasses.FrozenInstanceError):
        begun.current = first.current


def test_what_stretched_tolerances_hide_is_sought_where_it_could_act(begun):
    """They leave next to nothing over, and that says nothing of places."""
    fitted = fit_tolerances(begun)
    assert stretch(fitted.fitted.hypothesis) > STRETCHED, SEED
    tried = {}
    for misfit in (1.0, 2.0):
        state = dataclasses.replace(
            fitted, current=dataclasses.replace(fitted.current, misfit=misfit)
        )
        tried[misfit] = {repr(trial.effect) for trial in screen_catalogue(state).trials}
    assert 'joint_stiffness at joint_2' in tried[1.0], SEED
    left_out = tried[2.0] - tried[1.0]
    assert left_out and tried[1.0] < tried[2.0], tried
    assert all(name.startswith('joint_stiffness') for name in left_out), left_out


@pytest.mark.slow
def test_the_log_says_why_what_was_turned_down_and_what_was_decided(begun, caplog):
    with caplog.at_level(logging.DEBUG, logger='model_gap'):
        found = run_search(begun)
        decision = decide(found)
    text = caplog.text
    assert [item.effect.key for item in found.accepted] == [JointStiffness('joint_2').key], SEED
    assert 'joint_stiffness at joint_2 gains' in text
    turned_down = [
        line for line in caplog.messages if re.search('not tried|not fitted|dropped', line)
    ]
    assert turned_down and all(re.search(r': .*\d', line) for line in turned_down), turned_down
    (line,) = [item for item in caplog.records if item.name == 'model_gap.decide.decide']
    assert decision.verdict.value in line.getMessage()
    assert all(reason in line.getMessage() for reason in decision.reasons)
