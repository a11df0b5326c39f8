"""Messages that claim a false time, rate or size: the good data go on as if they were alone."""

from dataclasses import replace

import numpy as np
import pytest

from autonomous_modal_analysis.identified.identification import identify_recording
from modal_core.measurements import JointSamples, SampleBlock, StampedSamples
from modal_recordings import open_recording, RecordingWriter
from modal_recordings.messages import encode
from oma_identifier.intake.joint_track import JointTrack
from oma_identifier.intake.sample_buffer import SampleBuffer
from oma_identifier.intake.topic_intake import in_order
from oma_identifier.settings import IdentificationSettings

START = 1_700_000_000_000_000_000
HOUR = 3600 * 10**9
SETTINGS = IdentificationSettings(window_s=4.0, hop_s=2.0)
SEED = 11
DURATION_S = 14.0
PLACES = (0.0, 0.001, 0.4, 0.999)


def sensor(source, rate_hz=250.0, duration_s=DURATION_S):
    """One message per sample."""
    rng = np.random.default_rng([SEED, len(source)])
    stamps = START + np.round(np.arange(int(duration_s * rate_hz)) / rate_hz * 1e9).astype(int)
    return [
        StampedSamples(source, 'link', stamps[i : i + 1], rng.normal(size=(1, 3)))
        for i in range(len(stamps))
    ]


def recorder(source='/block', rate_hz=500.0, rows=25, duration_s=DURATION_S):
    rng = np.random.default_rng([SEED, len(source)])
    return [
        SampleBlock(
            source,
            START + round(first / rate_hz * 1e9),
            first,
            rate_hz,
            ('b0', 'b1', 'b2'),
            rng.normal(size=(rows, 3)).astype(np.float32),
        )
        for first in range(0, int(duration_s * rate_hz), rows)
    ]


def stamp_of(message):
    return int(np.min(message.stamp_ns))


CELLS = {
    'sensor': lambda: sensor('/imu'),
    'recorder': recorder,
    'both': lambda: sorted([*sensor('/imu'), *sensor('/other'), *recorder()], key=stamp_of),
}


def windows_of(measurements, settings=SETTINGS):
    buffer = SampleBuffer(settings)
    windows = []
    for measurement in measurements:
        buffer.add(measurement)
        windows += buffer.windows()
    return buffer, [*windows, *buffer.finish()]


def inserted(messages, place, extra):
    at = int(place * len(messages))
    return [*messages[:at], *extra, *messages[at:]]


def check_same(windows, clean, besides=0):
    """As many windows, with the samples of the clean run but for a few."""
    assert len(windows) == len(clean)
    for window, truth in zip(windows, clean, strict=True):
        assert window.samples.channel_names == truth.samples.channel_names
        assert window.samples.sample_rate_hz == truth.samples.sample_rate_hz
        assert window.samples.start_ns == truth.samples.start_ns
        values, true_values = window.samples.acceleration, truth.samples.acceleration
        n_rows = len(values)
        assert len(true_values) - besides <= n_rows <= len(true_values)
        differ = np.abs(values - true_values[:n_rows]) > 1e-9
        assert np.count_nonzero(differ.any(axis=1)) <= besides, f'seed {SEED}'


@pytest.mark.parametrize('ahead_ns', [HOUR, -HOUR, 10 * 10**9, -10 * 10**9, 5 * 10**17])
@pytest.mark.parametrize('cell', CELLS)
def test_a_stamp_that_others_do_not_confirm_is_set_aside(cell, ahead_ns):
    sent = CELLS[cell]()
    _, clean = windows_of(sent)
    for place in PLACES[2:]:
        for count in (1, 9):
            at = int(place * (len(sent) - count))
            wild = [replace(m, stamp_ns=m.stamp_ns + ahead_ns) for m in sent[at : at + count]]
            buffer, windows = windows_of([*sent[:at], *wild, *sent[at + count :]])
            # A sample beside a filled one changes with it: 24 taps and the filter's order.
            check_same(windows, clean, besides=count * 200)
            assert 1 <= buffer.counters.reasons['stamp_unconfirmed'] <= count


@pytest.mark.parametrize('cell', CELLS)
def test_a_false_first_stamp_costs_that_message_only(cell):
    sent = CELLS[cell]()
    wild = replace(sent[0], stamp_ns=sent[0].stamp_ns + HOUR)
    buffer, windows = windows_of([wild, *sent[1:]])
    assert len(windows) == len(windows_of(sent)[1])
    assert buffer.counters.reasons == {'stamp_unconfirmed': 1}
    assert windows[0].samples.start_ns - START <= 50_000_000


@pytest.mark.parametrize('count', [1, 9, 60])
@pytest.mark.parametrize('cell', CELLS)
def test_a_new_topic_of_another_time_silences_nobody(cell, count):
    sent = CELLS[cell]()
    _, clean = windows_of(sent)
    for place in PLACES:
        extra = [replace(m, stamp_ns=m.stamp_ns + HOUR) for m in sensor('/new', 100.0)[:count]]
        buffer, windows = windows_of(inserted(sent, place, extra))
        check_same(windows, clean)
        counted = buffer.counters.reasons
        assert counted == ({'clock_apart': 1} if count > 9 else {'stamp_unconfirmed': count})


@pytest.mark.parametrize('topic', ['/imu', '/new'])
def test_one_false_stamp_every_second_silences_nobody(topic):
    sent = CELLS['both']()
    _, clean = windows_of(sent)
    wild = [replace(m, source=topic, stamp_ns=m.stamp_ns + HOUR) for m in sensor('/x', 1.0)]
    stream = sorted(
        [*((stamp_of(m) - HOUR, m) for m in wild), *((stamp_of(m), m) for m in sent)],
        key=lambda item: item[0],
    )
    _, windows = windows_of([message for _, message in stream])
    check_same(windows, clean)


@pytest.mark.parametrize('count', [1, 20])
@pytest.mark.parametrize('rate_hz', [1e7, 1e5, 1e-9])
@pytest.mark.parametrize('cell', CELLS)
def test_a_rate_that_stamps_do_not_confirm_is_refused(cell, rate_hz, count):
    sent = CELLS[cell]()
    _, clean = windows_of(sent)
    rng = np.random.default_rng(SEED)
    for place in PLACES:
        stamp = START + round(place * DURATION_S * 1e9)
        extra = [
            SampleBlock(
                '/evil',
                stamp + n * 10**7,
                1000 * n,
                rate_hz,
                ('e0', 'e1'),
                rng.normal(size=(1000, 2)).astype(np.float32),
            )
            for n in range(count)
        ]
        buffer, windows = windows_of(inserted(sent, place, extra))
        check_same(windows, clean)
        assert sum(buffer.counters.reasons.values()) >= 1
        assert set(buffer.counters.reasons) <= {'rate_unconfirmed', 'rate_refused'}


@pytest.mark.parametrize(
    'change',
    [
        {'sample_rate_hz': 1e7},
        {'sample_rate_hz': 50.0},
        {'first_index': 2**61},
        {'first_index': 0},
    ],
)
def test_one_block_with_a_false_header_is_put_right_where_it_fits(change):
    sent = recorder()
    _, clean = windows_of(sent)
    for at in (60, 100, 250):
        stream = [*sent[:at], replace(sent[at], **change), *sent[at + 1 :]]
        buffer, windows = windows_of(stream)
        check_same(windows, clean)
        assert sum(buffer.counters.reasons.values()) == 1


def test_blocks_that_alternate_rates_keep_the_true_one():
    sent = recorder()
    stream = []
    for block in sent:
        stream += [block, replace(block, sample_rate_hz=1234.5)]
    _, windows = windows_of(stream)
    check_same(windows, windows_of(sent)[1])


def test_samples_a_nanosecond_apart_make_no_rate():
    sent = CELLS['both']()
    _, clean = windows_of(sent)
    for place in PLACES:
        stamps = START + round(place * DURATION_S * 1e9) + np.arange(2000)
        rows = np.random.default_rng(SEED).normal(size=(2000, 3))
        extra = [StampedSamples('/fast', 'link', stamps, rows)]
        buffer, windows = windows_of(inserted(sent, place, extra))
        assert [w.samples.sample_rate_hz for w in windows] == [500.0] * len(clean)
        names = clean[0].samples.channel_names
        assert all(w.samples.channel_names == names for w in windows)
        assert 'rate_unconfirmed' in buffer.counters.reasons


def test_many_topics_of_one_message_leave_room_for_a_true_one():
    rng = np.random.default_rng(SEED)
    names = ('e0', 'e1')
    junk = [
        SampleBlock(f'/junk{n}', START, 0, 1e6, names, rng.normal(size=(10, 2)))
        for n in range(600)
    ]
    sent = recorder()
    buffer, windows = windows_of([*junk, *sent])
    check_same(windows, windows_of(sent)[1])
    assert buffer.counters.reasons == {'rate_unconfirmed': 600}


def test_a_window_that_would_not_fit_the_memory_is_refused_with_advice():
    rate_hz, rows, n_channels = 1e5, 20_000, 64
    block = np.zeros((rows, n_channels), np.float32)
    names = tuple(f'c{n}' for n in range(n_channels))
    buffer = SampleBuffer(IdentificationSettings(window_s=60.0))
    for n in range(12):
        stamp = START + round(n * rows / rate_hz * 1e9)
        buffer.add(SampleBlock('/fast', stamp, n * rows, rate_hz, names, block))
    assert list(buffer.finish()) == []
    text = buffer.counters.describe('window_too_large')
    assert '2.86 GiB' in text and 'window_s' in text and 'lower rate' in text


def test_a_real_change_of_all_clocks_goes_on():
    sent = CELLS['both']()
    at = len(sent) // 2
    jumped = [replace(m, stamp_ns=m.stamp_ns + HOUR) for m in sent[at:]]
    _, windows = windows_of([*sent[:at], *jumped])
    late = [w for w in windows if w.samples.start_ns >= START + HOUR]
    assert len(late) >= 2 and all(len(w.samples.channels) == 9 for w in late)
    assert all(w.samples.end_ns <= START + 8 * 10**9 for w in windows if w not in late)


def test_one_clock_that_is_set_leaves_the_others():
    sent = CELLS['both']()
    jumped = [
        replace(m, stamp_ns=m.stamp_ns + HOUR)
        if m.source == '/imu' and stamp_of(m) > START + 5 * 10**9
        else m
        for m in sent
    ]
    buffer, windows = windows_of(jumped)
    assert buffer.counters.reasons['clock_apart'] == 1
    assert len(windows) == len(windows_of(sent)[1])
    assert windows[-1].samples.channel_names[-1] == 'b2'
    flags = {c.name: c.flags for c in windows[-1].quality.channels}
    assert 'clock_apart' in flags['imu.x'] and 'clock_apart' not in flags['other.x']


def joints(time_s, position, names=('j1', 'j2')):
    stamp = np.array([START + round(time_s * 1e9)])
    rows = np.full((1, len(names)), position)
    return JointSamples(stamp, names, rows, np.zeros_like(rows))


@pytest.mark.parametrize(
    'wild',
    [
        joints(3600.0, 9.0),
        joints(-3600.0, 9.0),
        joints(2.5, 9.0, ('gripper',)),
    ],
)
def test_a_joint_state_that_nothing_confirms_changes_no_pose(wild):
    for at in (0, 1, 250, 400):
        track = JointTrack(100.0)
        sent = [joints(0.01 * n, 0.5) for n in range(500)]
        for each in inserted(sent, at / 500, [wild] * 5):
            track.add(each, START)
        found = track.between(START, START + 5 * 10**9)
        assert found.joint_names == ('j1', 'j2')
        assert len(found.stamp_ns) == 500 and np.all(found.position == 0.5)


def test_joint_states_seen_once_at_the_beginning_are_kept():
    stream = [joints(0.0, 0.3), *sensor('/imu')]
    _, windows = windows_of(stream, IdentificationSettings(window_s=12.0))
    assert windows[0].pose is not None and windows[0].pose.position[0] == 0.3


def test_a_wild_stamp_does_not_spoil_the_order_of_a_late_poll():
    one, other = sensor('/a', 50.0, 4.0), sensor('/b', 50.0, 4.0)
    one[0] = replace(one[0], stamp_ns=one[0].stamp_ns + HOUR)
    ordered = [stamp_of(m) for m in in_order([*one, *other]) if stamp_of(m) < START + HOUR]
    assert np.diff(ordered).min() >= -20_000_000


def test_a_recording_with_false_headers_is_identified_as_if_they_were_not_there(tmp_path):
    time_s = np.arange(30 * 200) / 200.0
    rng = np.random.default_rng(SEED)
    tone = np.convolve(rng.normal(size=len(time_s) + 400), _ring(12.0, 0.02), 'valid')
    values = tone[: len(time_s), None] * [1.0, -0.6, 0.3] + 0.01 * rng.normal(size=(6000, 3))
    names = ('b0', 'b1', 'b2')
    messages = []
    for first in range(0, 6000, 20):
        stamp = START + round(first * 5e6)
        block = SampleBlock('/b', stamp, first, 200.0, names, values[first : first + 20])
        messages += encode(block, '/b')
    evil = SampleBlock('/evil', START + 10**9, 0, 1e7, ('e',), np.ones((1000, 1)))
    wild = replace(sensor('/imu', 10.0, 1.0)[0], stamp_ns=np.array([START + HOUR]))
    found = []
    for number, extra in enumerate(([], [*encode(evil, '/evil'), *encode(wild, '/imu')])):
        path = tmp_path / f'{number}.mcap'
        with RecordingWriter(path) as writer:
            for place, raw in enumerate([*messages[:40], *extra, *messages[40:]]):
                writer.write(raw.topic, raw.message_type, START + place * 10**8, raw.data)
        settings = IdentificationSettings(window_s=15.0)
        found.append(identify_recording(open_recording(path), settings).identification)
    clean, spoilt = found
    assert len(spoilt.windows) == len(clean.windows) >= 2
    assert [m.frequency_hz for m in spoilt.modes] == [m.frequency_hz for m in clean.modes]
    assert abs(spoilt.modes.frequency_hz[0] - 12.0) < 0.2


def _ring(frequency_hz, damping_ratio):
    time_s = np.arange(400) / 200.0
    omega = 2.0 * np.pi * frequency_hz
    return np.exp(-damping_ratio * omega * time_s) * np.cos(omega * time_s)
