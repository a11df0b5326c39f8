"""Which poses are held out: whole poses, as the campaign says, the rest drawn."""

import numpy as np
import pytest

from modal_core.channel import Sensor, SensorLayout
from modal_core.errors import SettingsError
from model_gap.campaign.campaign import Campaign, GapRecord
from model_gap.fit.split import split


def campaign(*said):
    """Return a campaign of two records per pose; what each says, pose after pose."""
    nothing = np.zeros((8, 1))
    records = [
        GapRecord(
            f'p{pose}_{level}.mcap', np.full(1, float(pose)), str(level), 100.0, nothing, nothing,
            nothing, nothing, heldout=heldout,
        )
        for pose, pair in enumerate(said)
        for level, heldout in enumerate(pair)
    ]  # fmt: skip
    return Campaign(tuple(records), SensorLayout((Sensor('a', 'b'),)), ('joint',))


def marks(found):
    pairs = [item.heldout for item in found.records]
    assert pairs[::2] == pairs[1::2], 'a pose is wholly fitted or wholly held out'
    return pairs[::2]


@pytest.mark.parametrize('seed', range(5))
def test_one_record_to_fit_leaves_the_others_to_be_drawn(seed):
    said = [(None, False), *[(None, None)] * 4]
    found = marks(split(campaign(*said), np.random.default_rng(seed)))
    assert not found[0]
    assert sum(found) == 2, 'two fifths of five poses'


def test_one_record_held_out_holds_out_its_pose():
    said = [(None, True), (None, None), (None, None)]
    assert marks(split(campaign(*said), np.random.default_rng(0))) == [True, False, False]


def test_poses_are_drawn_beside_those_said_up_to_the_usual_share():
    said = [(True, True), *[(None, None)] * 8, (False, False)]
    found = marks(split(campaign(*said), np.random.default_rng(0)))
    assert found[0] and not found[-1]
    assert sum(found) == 4, 'two fifths of ten poses'


def test_a_campaign_that_says_all_is_taken_at_its_word():
    said = [(True, True), (True, True), (False, False)]
    assert marks(split(campaign(*said), np.random.default_rng(0))) == [True, True, False]


def test_a_pose_both_fitted_and_held_out_is_refused():
    with pytest.raises(SettingsError, match='one pose') as caught:
        split(campaign((True, False), (None, None)), np.random.default_rng(0))
    assert 'p0_0.mcap, p0_1.mcap' in str(caught.value)


def test_everything_held_out_is_refused():
    with pytest.raises(SettingsError, match='nothing is left to fit'):
        split(campaign((True, True), (True, None)), np.random.default_rng(0))
