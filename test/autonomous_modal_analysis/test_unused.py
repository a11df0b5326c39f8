"""What a recording holds and an identification does not use is told."""

from dataclasses import replace

import numpy as np
import pytest

from autonomous_modal_analysis.identified.identification import identify_recording
from modal_core.errors import IdentificationError
from modal_core.measurements import JointSamples, SampleBlock
from modal_recordings import open_recording, RecordingWriter
from modal_recordings.messages import encode
from oma_identifier.settings import IdentificationSettings

START, RATE_HZ, SEED = 1_700_000_000_000_000_000, 100.0, 3
SETTINGS = IdentificationSettings(window_s=10.0)


def blocks(topic, names=('a', 'b', 'c'), seed=SEED):
    values = np.random.default_rng(seed).normal(size=(1200, len(names))).astype(np.float32)
    return [
        SampleBlock(
            topic, START + first * 10_000_000, first, RATE_HZ, names, values[first : first + 20]
        )
        for first in range(0, 1200, 20)
    ]


def identified(path, measurements):
    writer = RecordingWriter(path)
    for measurement in measurements:
        for raw in encode(measurement, getattr(measurement, 'source', '/joint_states')):
            writer.write(raw.topic, raw.message_type, raw.log_time_ns, raw.data)
    return identify_recording(open_recording(writer.close()), SETTINGS).identification


def in_turn(*topics):
    return [block for group in zip(*topics, strict=True) for block in group]


def test_a_sound_recording_has_nothing_unused(tmp_path):
    sent = in_turn(blocks('/one'), blocks('/other', ('d', 'e'), seed=4))
    assert identified(tmp_path / 'sound.mcap', sent).damage == ()


def test_channels_that_two_topics_send_are_told(tmp_path):
    found = identified(tmp_path / 'twice.mcap', in_turn(blocks('/one'), blocks('/other', seed=4)))
    assert [channel.name for channel in found.channels] == ['a', 'b', 'c']
    (told,) = found.damage
    assert '/other' in told and 'not used' in told


def test_blocks_that_are_set_aside_are_told(tmp_path):
    sent = blocks('/one')
    sent[30] = replace(sent[30], stamp_ns=sent[30].stamp_ns + 3600 * 10**9, first_index=7)
    sent[31] = replace(sent[31], stamp_ns=sent[31].stamp_ns - 3600 * 10**9, first_index=9)
    found = identified(tmp_path / 'wild.mcap', sent)
    assert any('messages not used' in told for told in found.damage), found.damage


def still(block):
    return replace(block, first_index=0)


def joint_states():
    stamps = START + np.arange(1200) * 10_000_000
    names = tuple(f'joint_{number}' for number in range(6))
    none = np.full((1, 6), np.nan)
    return [JointSamples(stamps[i : i + 1], names, np.zeros((1, 6)), none) for i in range(1200)]


@pytest.mark.parametrize(
    ('measurements', 'words'),
    [
        (lambda: [still(block) for block in blocks('/one')], 'counters'),
        (lambda: [replace(b, acceleration=b.acceleration[:0]) for b in blocks('/one')], 'refused'),
        (joint_states, 'no accelerations'),
    ],
)
def test_a_recording_without_usable_samples_is_not_called_too_short(tmp_path, measurements, words):
    with pytest.raises(IdentificationError, match=words) as caught:
        identified(tmp_path / 'none.mcap', measurements())
    assert 'too short' not in str(caught.value)


def test_two_recorders_of_one_topic_are_told_apart(tmp_path):
    """Their stamps in turn are the times of neither."""
    first, second = blocks('/one'), blocks('/one', ('d', 'e'), seed=4)
    late = [replace(block, stamp_ns=block.stamp_ns + 1_300_000) for block in second]
    writer = RecordingWriter(tmp_path / 'two.mcap')
    for block in in_turn(first, late):
        for raw in encode(block, '/one'):
            writer.write(raw.topic, raw.message_type, raw.log_time_ns, raw.data)
    topics = open_recording(writer.close()).info().topics
    assert [topic.channels for topic in topics] == [('a', 'b', 'c'), ('d', 'e')]
    for topic in topics:
        assert topic.measured_rate_hz == pytest.approx(RATE_HZ, rel=1e-6)
        assert (topic.n_messages, topic.n_samples, topic.gaps) == (60, 1200, ())
