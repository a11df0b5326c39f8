"""A predictor says the same whatever it was asked before."""

from dataclasses import replace

import numpy as np
import pytest

from model_gap.effects.sensor_gain import SensorGain
from model_gap.fit.linearise import tolerance_columns
from model_gap.search import Search

SEED = 33
ELBOW = SensorGain('sensor:elbow')


@pytest.fixture(scope='module')
def search(campaign_of, robot):
    campaign = campaign_of((), SEED, n_fit=2, n_held=0, duration=6.0)
    return Search.begin(robot, campaign, simulated=True)


@pytest.fixture
def predictor(search):
    """Return one that was asked nothing yet."""
    used = search.data.loudest
    return type(used)(used.model, used.records, used.steps_per_s, used.hanging)


def test_derivatives_do_not_depend_on_the_gain_that_was_asked_before(search, predictor):
    """Only sensors differ: the arm's motion is computed once, their gains are not carried over."""
    plain, louder = search.nominal, search.nominal.with_effect(ELBOW, (1.5,))
    fresh = tolerance_columns(plain, replace(predictor, cache=type(predictor.cache)()))
    predictor.predict(louder.cell())
    again = tolerance_columns(plain, predictor)
    np.testing.assert_array_equal(again, fresh)


def test_a_shared_cache_keeps_records_apart(search, predictor):
    cell = search.nominal.cell()
    whole = predictor.predict(cell)
    last = replace(predictor, records=predictor.records[-1:])
    assert last.cache is predictor.cache
    (alone,) = last.predict(cell)
    np.testing.assert_allclose(alone, whole[-1], rtol=1e-12)
    halved = replace(predictor, steps_per_s=predictor.steps_per_s / 2, hanging=True)
    assert np.abs(halved.predict(cell)[-1] - whole[-1]).max() > 0.0
    np.testing.assert_array_equal(predictor.predict(cell)[-1], whole[-1])


def test_the_same_cell_is_computed_once(search, predictor):
    cell = search.nominal.cell()
    assert predictor.systems(cell.spec, cell.channels) is predictor.systems(
        cell.spec, cell.channels
    )
    assert predictor.solved(cell).states is predictor.solved(cell).states
