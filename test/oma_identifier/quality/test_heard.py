"""Sensors of a lower rate than the others say nothing of modes that they cannot hear."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.mode import Mode, ModeSet
from modal_core.quality import ChannelQuality
from oma_identifier.quality import heard_to_hz, without_unheard

NAMES = ('imu.x', 'imu.y', 'accel.x', 'accel.y')
RATES = 100.0, 100.0, 250.3, 249.7
SHAPE = np.array([1e-4j, -2e-4, 1.0, 0.5 + 0.1j])
STD = np.full(4, 0.01 + 0.01j)


def channels(rates=RATES):
    return [
        ChannelQuality(name, measured_rate_hz=rate)
        for name, rate in zip(NAMES, rates, strict=True)
    ]


def modes(*frequencies_hz, std=STD):
    each = (Mode(f, 0.01, SHAPE, shape_std=std) for f in frequencies_hz)
    return ModeSet(tuple(each), NAMES)


def test_above_its_reach_a_slow_sensor_takes_no_part():
    found = without_unheard(modes(20.0, 44.0, 46.0, 100.0), channels())
    for mode in found.modes[:2]:
        assert np.array_equal(mode.shape, SHAPE) and np.array_equal(mode.shape_std, STD)
    for mode in found.modes[2:]:
        assert np.array_equal(mode.shape, [0.0, 0.0, *SHAPE[2:]])
        assert np.array_equal(mode.shape_std, [0.0, 0.0, *STD[2:]])


def test_a_shape_without_deviations_stays_without():
    (mode,) = without_unheard(modes(60.0, std=None), channels())
    assert mode.shape_std is None and mode.shape[0] == 0.0


@pytest.mark.parametrize('rates', [(250.0,) * 4, (248.0, 250.0, 249.0, 250.0), (0.0,) * 4])
def test_sensors_of_one_rate_all_take_part(rates):
    given = modes(60.0)
    assert without_unheard(given, channels(rates)) is given
    assert not np.isfinite(heard_to_hz(NAMES, channels(rates))).any()


def test_a_mode_that_no_sensor_hears_is_left_as_it_is():
    slow = ModeSet(tuple(replace(m, shape=SHAPE[:2]) for m in modes(60.0, std=None)), NAMES[:2])
    (mode,) = without_unheard(slow, channels())
    assert np.array_equal(mode.shape, SHAPE[:2])
