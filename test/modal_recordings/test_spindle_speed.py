"""The spindle's speed comes from a topic, a channel or a column, and is said to be missing."""

import struct

import numpy as np
import pytest

from modal_core.errors import RecordingError
from modal_core.measurements import SampleBlock
from modal_recordings import open_recording, RecordingWriter
from modal_recordings.messages import ENCAPSULATION, encode, RawMessage
from modal_recordings.spindle_speed import factor_of

SECOND_NS, RATE_HZ, SEED = 1_000_000_000, 100.0, 20


def write_mcap(path, topic='/spindle_speed_rpm', message_type='std_msgs/msg/Float64'):
    """Write two seconds of two channels, one of them a speed, and a speed on a topic."""
    rng = np.random.default_rng(SEED)
    with RecordingWriter(path) as writer:
        for second in range(2):
            rows = np.column_stack([rng.standard_normal(100), np.full(100, 120.0 + second)])
            block = SampleBlock(
                '/acceleration_block', second * SECOND_NS, 100 * second, RATE_HZ,
                ('tip', 'tacho_rpm'), rows.astype(np.float32),
            )  # fmt: skip
            number = ENCAPSULATION + struct.pack('<d', 600.0 + second)
            speed = RawMessage(topic, message_type, second * SECOND_NS, number)
            for message in (*encode(block, '/acceleration_block'), speed):
                writer.write(message.topic, message.message_type, second * SECOND_NS, message.data)
    return path


@pytest.mark.parametrize(
    ('name', 'unit', 'factor'),
    [
        ('spindle', '', 1 / 60),
        ('spindle [Hz]', '', 1.0),
        ('omega', 'rad/s', 0.5 / np.pi),
        ('speed_rad_s', '', 0.5 / np.pi),
        ('/speed_hz', '', 1.0),
        ('n [1/min]', '', 1 / 60),
    ],
)
def test_turns_per_second_follow_from_the_unit_or_the_name(name, unit, factor):
    assert factor_of(name, unit) == pytest.approx(factor)


def test_the_usual_topic_is_taken_and_another_one_by_its_name(tmp_path):
    usual = open_recording(write_mcap(tmp_path / 'a.mcap')).spindle_speed()
    np.testing.assert_allclose(usual.speed_hz, [10.0, 601.0 / 60.0])
    np.testing.assert_array_equal(usual.stamp_ns, [0, SECOND_NS])
    path = write_mcap(tmp_path / 'b.mcap', '/cnc/speed_hz')
    assert open_recording(path).spindle_speed() is None
    named = open_recording(path, spindle='cnc/speed_hz').spindle_speed()
    np.testing.assert_allclose(named.speed_hz, [600.0, 601.0])


def test_a_channel_is_the_speed_and_no_response(tmp_path):
    recording = open_recording(write_mcap(tmp_path / 'a.mcap'), spindle='tacho_rpm')
    speed = recording.spindle_speed()
    assert len(speed.stamp_ns) == 200
    np.testing.assert_allclose(speed.speed_hz[[0, -1]], [2.0, 121.0 / 60.0])
    assert recording.info().channels == ('tip',)


@pytest.mark.parametrize('heading', ['spindle [rpm]', 'spindle', 'spindle [Hz]'])
def test_a_column_is_the_speed_and_no_response(tmp_path, heading):
    rng = np.random.default_rng(SEED)
    values = np.column_stack([rng.standard_normal((500, 2)), np.linspace(600.0, 660.0, 500)])
    path = tmp_path / 'log.csv'
    np.savetxt(path, values, '%.9g', ',', header=f'tip [m/s^2],mid [g],{heading}', comments='')
    recording = open_recording(path, sample_rate_hz=RATE_HZ, spindle='spindle')
    factor = 1.0 if 'Hz' in heading else 1 / 60
    np.testing.assert_allclose(recording.spindle_speed().speed_hz, factor * values[:, 2], 1e-6)
    assert recording.info().channels == ('tip', 'mid')
    assert not [note for note in recording.notes if 'left out' in note], recording.notes
    assert any('spindle tells the speed' in note for note in recording.notes)


@pytest.mark.parametrize(('heading', 'factor'), [('speed [rpm]', 60.0), ('speed [Hz]', 1.0)])
def test_a_column_that_is_named_beside_the_file_is_the_speed(tmp_path, heading, factor):
    values = np.random.default_rng(4).standard_normal((500, 3))
    np.save(tmp_path / 'mill.npy', values)
    recording = open_recording(
        tmp_path / 'mill.npy',
        sample_rate_hz=100.0,
        channels=['tip', 'mid', heading],
        spindle='speed',
    )
    assert recording.channel_names == ('tip', 'mid')
    told = recording.spindle_speed()
    assert np.allclose(told.speed_hz, values[:, 2] / factor)


def test_a_speed_that_is_missing_is_one_line(tmp_path):
    path = write_mcap(tmp_path / 'a.mcap')
    with pytest.raises(RecordingError, match=r'no speed of a spindle.*found other') as said:
        open_recording(path, spindle='other').spindle_speed()
    assert '\n' not in str(said.value)
    with pytest.raises(RecordingError, match='no speed of a spindle'):
        open_recording(path, spindle='/acceleration_block')
    table = tmp_path / 'log.csv'
    np.savetxt(table, np.ones((300, 2)), '%g', ',', header='tip,mid', comments='')
    with pytest.raises(RecordingError, match=r'no speed of a spindle.*expected tip, mid'):
        open_recording(table, sample_rate_hz=RATE_HZ, spindle='rpm')
