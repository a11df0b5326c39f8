"""The calibration in words: as many digits as a deviation has, and none where it has none."""

import math
from types import SimpleNamespace

import numpy as np

from model_gap.calibration import Calibrated, calibration_words, encoder_words, Mount
from model_gap.decide import Verdict
from model_gap.open_encoders import OtherEncoders


def test_a_small_deviation_is_not_none():
    items = (
        Calibrated('centre of mass of tip (z)', 1.6e-3, 0.05e-3, 'm', 1.0, 32.0, True),
        Calibrated('damping of q1', 1.0794, 0.0201, '1', 1.0, 3.9, True),
        Calibrated('zero of q2', -0.5, 0.004, 'deg', 1.0, 125.0, True),
    )
    first, second = calibration_words(items, [Mount('boom', 2.0, 0.003)])
    assert '(z) +1.600 ± 0.050 mm' in first
    assert 'q1 1.079 ± 0.020 times nominal' in first
    assert 'q2 −0.5000 ± 0.0040°' in first
    assert second.endswith('boom by 2.0000 ± 0.0030°')


def test_what_may_stand_for_something_unexplained_has_no_deviation():
    items = (Calibrated('damping of q3', 1.22, math.nan, '1', 2.0, 5.8, True),)
    (line,) = calibration_words(items, [])
    assert line == (
        'calibrated (or standing for what is unexplained): damping of q3 1.220 times nominal'
    )


def test_a_spring_that_is_named_with_a_factor_is_not_said_to_be_undetermined():
    items = tuple(
        Calibrated(f'stiffness of {joint}', 1.0, 0.02, '1', 0.0, 0.0, False) for joint in 'XY'
    )
    assert calibration_words(items, [], ['Y']) == [
        'not determined by this campaign: stiffness of X'
    ]
    assert calibration_words(items[1:], [], ['Y']) == []


def test_an_encoder_that_explains_it_as_well_is_told():
    """Two mounts on one link that are turned alike are an encoder that is off as well."""
    other = OtherEncoders({'tilt': (0.82, 0.055)}, np.ones(3))
    named = SimpleNamespace(verdict=Verdict.NAMED)
    (line,) = encoder_words(SimpleNamespace(other_encoders=other, decision=named))
    assert 'encoder of tilt: that it stands 0.820 ± 0.055 deg further' in line
    assert encoder_words(SimpleNamespace(other_encoders=None, decision=named)) == []
