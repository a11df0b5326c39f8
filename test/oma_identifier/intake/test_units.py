"""What channels measure, as layouts, names of channels and sensors say."""

import numpy as np
import pytest

from modal_core.channel import SensorLayout
from modal_core.errors import LayoutError
from modal_core.measurements import SampleBlock, StampedSamples
from oma_identifier.intake import SampleBuffer
from oma_identifier.settings import IdentificationSettings

START = 1_700_000_000_000_000_000
G = 9.80665
DEGREE = np.pi / 180.0
RATE_HZ = 100.0


def layout(**sensor):
    entry = {'name': 'belt', 'frame_id': 'link_1', **sensor}
    return SensorLayout.from_mapping({'sensors': [entry]}, 'cell.yaml')


def window_of(measurements, known=None, **settings):
    buffer = SampleBuffer(IdentificationSettings(window_s=10.0, **settings), known)
    for measurement in measurements:
        buffer.add(measurement)
    return next(iter([*buffer.windows(), *buffer.finish()])).samples


def blocks(names, units=()):
    rng = np.random.default_rng(5)
    for first in range(0, 1000, 50):
        rows = rng.standard_normal((50, len(names))).astype(np.float32)
        yield SampleBlock(
            'daq', START + first * 10_000_000, first, RATE_HZ, tuple(names), rows, tuple(units)
        )


def imu(turns):
    rng = np.random.default_rng(6)
    stamps = START + np.arange(1000, dtype=np.int64) * 10_000_000
    values = rng.standard_normal((1000, 6))
    return StampedSamples('/imu/elbow', 'link_3', stamps, values[:, :3], turns(values[:, 3:]))


@pytest.mark.parametrize(
    ('unit', 'si', 'factor'),
    [('g', 'm/s^2', G), ('mm/s', 'm/s', 1e-3), ('um', 'm', 1e-6), ('deg/s', 'rad/s', DEGREE)],
)
def test_a_layout_says_what_its_sensors_measure(unit, si, factor):
    known = layout(unit=unit)
    names = [channel.name for channel in known.channels]
    found = window_of(blocks(names), known)
    assert [channel.unit for channel in found.channels] == [si] * 3
    sent = np.concatenate([block.acceleration for block in blocks(names)])
    assert np.allclose(found.acceleration, factor * sent[: len(found.acceleration)], rtol=1e-6)
    assert SensorLayout.from_mapping(known.to_mapping(), 'again').channels == known.channels


@pytest.mark.parametrize('unit', ['furlong', 'V', 's', 3, ''])
def test_an_unknown_unit_of_a_layout_is_refused_in_one_line(unit):
    with pytest.raises(LayoutError, match=r'sensors\[0\].unit') as caught:
        layout(unit=unit)
    assert '\n' not in str(caught.value)


def test_names_of_channels_may_end_in_their_unit():
    found = window_of(blocks(['a [g]', 'v [mm/s]', 'left [top]', 'plain']))
    assert found.channel_names == ('a', 'v', 'left [top]', 'plain')
    assert [channel.unit for channel in found.channels] == ['m/s^2', 'm/s', 'm/s^2', 'm/s^2']
    sent = np.concatenate([block.acceleration for block in blocks('1234')])
    wanted = sent[: len(found.acceleration)] * (G, 1e-3, 1.0, 1.0)
    assert np.allclose(found.acceleration, wanted, rtol=1e-6)


def test_what_a_recording_states_goes_before_the_layout():
    known = layout(unit='g')
    names = [channel.name for channel in known.channels]
    found = window_of(blocks(names, ['m/s'] * 3), known)
    assert [channel.unit for channel in found.channels] == ['m/s'] * 3
    sent = np.concatenate([block.acceleration for block in blocks(names)])
    assert np.allclose(found.acceleration, sent[: len(found.acceleration)])


@pytest.mark.parametrize('known', [None, layout(topic='imu/elbow')])
def test_gyroscopes_take_part_when_asked(known):
    found = window_of([imu(lambda values: values)], known)
    assert len(found.channels) == 3
    found = window_of([imu(lambda values: values)], known, gyroscopes=True)
    sensor = 'belt' if known else 'imu/elbow'
    names = [*(f'{sensor}.{axis}' for axis in 'xyz'), *(f'{sensor}.gyro_{axis}' for axis in 'xyz')]
    assert list(found.channel_names) == names
    assert [channel.unit for channel in found.channels] == ['m/s^2'] * 3 + ['rad/s'] * 3
    assert found.channels[4].direction == found.channels[1].direction == (0.0, 1.0, 0.0)
    sent = imu(lambda values: values)
    assert np.allclose(found.acceleration[:, 3:], sent.angular_velocity[: len(found.acceleration)])


@pytest.mark.parametrize(
    'turns', [lambda values: None, np.zeros_like, lambda values: np.full_like(values, np.nan)]
)
def test_an_imu_without_gyroscopes_has_no_channels_of_them(turns):
    found = window_of([imu(turns)], gyroscopes=True)
    assert len(found.channels) == 3
