"""Modes of recordings beside those of the model."""

from dataclasses import replace

import numpy as np

from model_gap.modes import mode_pairs
from model_gap.search.search import Search

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
