"""Recordings whose log times are those of a program that copied them, not of the sensors."""

import numpy as np
import pytest

from modal_core.measurements import JointSamples, SampleBlock, StampedSamples
from modal_recordings import open_recording, RecordingWriter
from modal_recordings.messages import encode

SEED, START, RATE_HZ, SECONDS = 993800, 1_700_000_000_000_000_000, 100.0, 60
DAY_NS = 86_400_000_000_000
LOG_TIMES = {
    'copied in a tenth of the time': lambda number, stamp: START + DAY_NS + number * 200_000,
    'all at once': lambda number, stamp: START + DAY_NS,
    'no time': lambda number, stamp: 0,
    'in blocks of some seconds': lambda number, stamp: START + number // 2000 * 3_000_000_000,
}


def sent():
    """Return messages of two sensors, a converter and the joints, by their stamps."""
    rng = np.random.default_rng(SEED)
    n = round(SECONDS * RATE_HZ)
    stamps = START + np.arange(n) * round(1e9 / RATE_HZ)
    found = []
    for name in ('/a', '/b'):
        found += encode(StampedSamples(name, name[1:], stamps, rng.normal(size=(n, 3))), name)
    for first in range(0, n, 20):
        rows = rng.normal(size=(20, 2)).astype(np.float32)
        block = SampleBlock('/block', int(stamps[first]), first, RATE_HZ, ('u', 'v'), rows)
        found += encode(block, '/block')
    joints = np.zeros((n // 10, 2))
    found += encode(JointSamples(stamps[::10], ('j1', 'j2'), joints, joints), '/joint_states')
    return sorted(found, key=lambda message: message.log_time_ns)


def write(path, messages, log_time):
    with RecordingWriter(path) as writer:
        for number, m in enumerate(messages):
            writer.write(m.topic, m.message_type, log_time(number, m.log_time_ns), m.data)


def stamps_of(measurement):
    return np.atleast_1d(measurement.stamp_ns)


@pytest.mark.parametrize('by_topic', (False, True))
@pytest.mark.parametrize('how', LOG_TIMES)
def test_sensors_come_side_by_side_by_their_own_stamps(tmp_path, how, by_topic):
    messages = sent()
    if by_topic:
        messages.sort(key=lambda message: message.topic)
    path = tmp_path / 'copied.mcap'
    write(path, messages, LOG_TIMES[how])
    recording = open_recording(path)
    reached, n_samples = {}, 0
    for each in recording.measurements():
        topic = getattr(each, 'source', 'joints')
        reached[topic] = max(reached.get(topic, 0), int(stamps_of(each)[-1]))
        n_samples += len(stamps_of(each))
        if len(reached) == 4:
            # Who reads waits five seconds for a sensor, and one that is through is not silent.
            apart_s = 1e-9 * (max(reached.values()) - min(reached.values()))
            assert apart_s < 7.0, f'{how}: {reached}'
    n = round(SECONDS * RATE_HZ)
    assert n_samples == 2 * n + n // 20 + n // 10
    assert not recording.damage()
    assert recording.fraction_read == 1.0


@pytest.mark.parametrize('how', LOG_TIMES)
def test_a_replay_is_paced_by_their_own_stamps(tmp_path, how):
    messages = sent()
    path = tmp_path / 'copied.mcap'
    write(path, sorted(messages, key=lambda message: message.topic), LOG_TIMES[how])
    played = list(open_recording(path).messages())
    assert [m.log_time_ns for m in played] == [m.log_time_ns for m in messages]
    assert sorted(m.data for m in played) == sorted(m.data for m in messages)


def test_what_was_recorded_as_it_came_is_read_once(tmp_path):
    path = tmp_path / 'recorded.mcap'
    write(path, sent(), lambda number, stamp: stamp + 3_000_000)
    recording = open_recording(path)
    taken = [stamps_of(each) for each in recording.measurements()]
    assert max(1e-9 * float(np.ptp(each)) for each in taken) <= 0.25
    assert recording.fraction_read == 1.0
