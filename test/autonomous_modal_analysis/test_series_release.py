"""What one release of a series covers."""

import pytest

from autonomous_modal_analysis.mapping import Series, SeriesRelease, Stop
from modal_core.errors import BridgeError

POSE = (0.0,) * 6
SERIES = Series(
    'asked', 20.0, (Stop(POSE, 'plan1', '', 0.0, 22.0), Stop(POSE, 'plan2', 'way2', 30.0, 22.0))
)


def test_every_motion_of_the_series_and_no_other_is_released():
    release = SeriesRelease.of(SERIES, 'ROB_1', 100.0)
    for plan_hash in ('plan1', 'way2', 'plan2'):
        assert release.chosen(plan_hash, 'ROB_1', 101.0) == plan_hash
    for plan_hash in ('another', '', 'asked', SERIES.series_hash):
        assert release.chosen(plan_hash, 'ROB_1', 101.0) == ''


def test_it_is_of_one_controller():
    release = SeriesRelease.of(SERIES, 'ROB_1', 100.0)
    with pytest.raises(BridgeError, match='another controller'):
        release.chosen('plan1', 'ROB_2', 101.0)


def test_it_ends_by_itself():
    release = SeriesRelease.of(SERIES, 'ROB_1', 100.0)
    ends_s = 100.0 + 2.0 * 74.0 + 600.0
    assert release.chosen('plan1', 'ROB_1', ends_s - 1.0) == 'plan1'
    assert release.chosen('plan1', 'ROB_1', ends_s + 1.0) == ''
