"""Modes of recordings beside those of the model."""

from dataclasses import replace

import numpy as np
import pytest

from model_gap.campaign import CAMPAIGN, Campaign
from model_gap.effects.base_compliance import BaseCompliance
from model_gap.fit import Fit
from model_gap.modes import mode_pairs
from model_gap.search.search import Search
from structural_model.description import BaseSpec

SEED = 12


def test_the_modes_of_a_recording_are_those_of_the_arm_it_was_made_with(campaign_of, robot):
    """Behind motors that move; a channel that was not recorded takes no part."""
    campaign = campaign_of((), SEED, n_fit=1, n_held=0)
    records = tuple(replace(record, missing=(4,)) for record in campaign.records)
    campaign = replace(campaign, records=records)
    search = Search.begin(robot, campaign, simulated=True)
    pairs = mode_pairs(search, None, 55.0)
    matched = [pair for pair in pairs if pair.before is not None]
    assert len(matched) == len(pairs) > 6
    assert all(len(pair.mode.shape) == 11 for pair in pairs)
    assert np.median([pair.before.mac for pair in matched]) > 0.98, f'seed {SEED}'
    off = [pair.deviations(pair.before) for pair in matched]
    assert np.sqrt(np.mean(np.square(off))) < 2.0, f'seed {SEED}: {off}'
    # A band of less than an octave tells of none.
    assert mode_pairs(search, None, 5.0) == ()


def test_a_campaign_without_a_word_of_its_motion_knows_it_as_fast_as_its_recordings(campaign_of):
    campaign = campaign_of((), SEED, n_fit=1, n_held=0)
    plain = Campaign(campaign.records, campaign.layout, campaign.joint_names)
    rate_hz = campaign.records[0].sample_rate_hz
    assert plain.motion_rate_hz == rate_hz
    assert plain.motion_band_hz == CAMPAIGN.usable_share * rate_hz


@pytest.mark.slow
def test_a_number_whose_step_lets_something_give_way_that_did_not(campaign_of, robot):
    """Sideways springs under a base that only rocks: a step has more modes than the arm."""
    campaign = campaign_of((), SEED, n_fit=1, n_held=0)
    held = robot.replace(replace(robot.spec, base=BaseSpec()))
    search = Search.begin(held, campaign, simulated=True)
    base = BaseCompliance(None).detailed()
    hypothesis = search.nominal.with_effect(base, (1e-8, 4e-4, 0.0, 0.0))
    size = len(hypothesis.tolerances) + len(hypothesis.inner)
    fitted = Fit(hypothesis, 1.0, 0.0, np.eye(4), np.eye(size))
    sigmas = [
        pair.after.frequency_sigma_hz / pair.after.frequency_hz
        for pair in mode_pairs(search, fitted, 55.0, poses=1, levels=1)
        if pair.after is not None
    ]
    assert len(sigmas) > 3
    assert np.isfinite(sigmas).all(), f'seed {SEED}: {sigmas}'
    assert 0.0 < np.median(sigmas) < 1.0, f'seed {SEED}: {sigmas}'
