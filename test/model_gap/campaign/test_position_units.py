"""Joint positions in another unit are refused with the unit that they look like."""

from types import SimpleNamespace

import numpy as np
import pytest

from modal_core.errors import RecordingError
from model_gap.campaign.position_units import check_position_units

LIMITS = SimpleNamespace(position_low=np.array([-1.0, -2.9]), position_high=np.array([1.0, 2.9]))
ARM = SimpleNamespace(limits=LIMITS, sliding=(True, False), joint_names=('x', 'b'))


@pytest.mark.parametrize('pose', [(0.9, -2.8), (1.2, 7.0), (-3.0, 20.0)])
def test_metres_and_radians_are_taken(pose):
    check_position_units(np.array(pose), ARM, 'here')


@pytest.mark.parametrize(
    ('pose', 'words'),
    [
        ((0.5, 60.0), r'look like degrees \(found b 60, expected radians\); record angles'),
        ((427.0, 0.5), r'look like millimetres \(found x 427, expected metres\); record ways'),
        ((10.7, 60.0), r'like millimetres and degrees|like degrees and millimetres'),
        ((0.5, 5e4), r'out of all range \(found b 5e\+04, expected radians\)$'),
    ],
)
def test_another_unit_is_named_with_the_joint(pose, words):
    with pytest.raises(RecordingError, match=words):
        check_position_units(np.array(pose), ARM, 'here')
