"""The sample buffer: same windows however the data comes, faults found, counted and confined."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.channel import SensorLayout
from modal_core.measurements import JointSamples, SampleBlock, StampedSamples
from oma_identifier.intake.sample_buffer import SampleBuffer
from oma_identifier.settings import IdentificationSettings
from oma_identifier.time_axis.source_stream import SourceStream

START = 1_700_000_000_000_000_000
SETTINGS = IdentificationSettings(window_s=4.0, hop_s=2.0)
TONES = np.array([3.1, 17.7, 41.3, 78.0])


def signal(time_s, column):
    """A band-limited signal known at every instant."""
    phases = 0.7 * column + np.arange(len(TONES))
    return np.sin(2 * np.pi * TONES * time_s[:, None] + phases).sum(axis=1)


def samples(time_s, source='/imu/a', first_column=0):
    values = np.column_stack([signal(time_s, first_column + c) for c in range(3)])
    return StampedSamples(source, 'link', START + np.round(time_s * 1e9).astype(np.int64), values)


def pieces(measurement, size):
    for first in range(0, len(measurement.stamp_ns), size):
        part = slice(first, first + size)
        yield replace(
            measurement,
            stamp_ns=measurement.stamp_ns[part],
            acceleration=measurement.acceleration[part],
        )


def blocks(duration_s, rate=1000.0, rows=50, n_channels=3, start_s=0.0, source='/block'):
    n = int(duration_s * rate)
    time_s = start_s + np.arange(n) / rate
    values = np.column_stack([signal(time_s, c) for c in range(n_channels)])
    names = tuple(f'{source[1:]}{c}' for c in range(n_channels))
    return [
        SampleBlock(source, START + round(time_s[i] * 1e9), i, rate, names, values[i : i + rows])
        for i in range(0, n - rows + 1, rows)
    ]


def run(measurements, settings=SETTINGS, layout=None, finish=True):
    buffer = SampleBuffer(settings, layout)
    windows = []
    for measurement in measurements:
        buffer.add(measurement)
        windows += buffer.windows()
    if finish:
        windows += buffer.finish()
    return buffer, windows


def error_of(window, columns, margin=200):
    """Largest deviation from the true signal, away from the ends of the record."""
    s = window.samples
    time_s = (s.start_ns - START) * 1e-9 + np.arange(len(s.acceleration)) / s.sample_rate_hz
    truth = np.column_stack([signal(time_s, c) for c in columns])
    return np.abs(s.acceleration - truth)[margin:-margin].max()


def test_blocks_come_out_untouched():
    sent = blocks(10.0)
    _, windows = run(sent)
    data = np.concatenate([block.acceleration for block in sent])
    assert [w.samples.start_ns - START for w in windows[:4]] == [
        0,
        2 * 10**9,
        4 * 10**9,
        6 * 10**9,
    ]
    for index, window in enumerate(windows[:4]):
        first = 2000 * index
        assert np.array_equal(window.samples.acceleration, data[first : first + 4000])


@pytest.mark.parametrize('size', [1, 7, 100, 1000, 100000])
def test_windows_do_not_depend_on_batches(size):
    rng = np.random.default_rng(1)
    time_s = np.arange(9000) / 1000.0 + rng.normal(0, 5e-5, 9000)
    _, whole = run(pieces(samples(time_s), 250))
    _, parts = run(pieces(samples(time_s), size))
    assert len(whole) == len(parts) >= 3
    for one, other in zip(whole, parts, strict=True):
        assert one.samples.start_ns == other.samples.start_ns
        assert np.array_equal(one.samples.acceleration, other.samples.acceleration)
        assert one.quality == other.quality


def test_jitter_is_reconstructed():
    rng = np.random.default_rng(2)
    time_s = np.arange(9000) / 1000.0 + rng.normal(0, 5e-5, 9000).clip(-2e-4, 2e-4)
    _, windows = run(pieces(samples(time_s), 100))
    # Taken as uniform, 5 % jitter would err by 2 π 78 Hz 50 µs = 2.4 % of that tone, 0.03 rms.
    assert error_of(windows[1], range(3)) < 2e-3
    quality = windows[1].quality.channels[0]
    assert quality.jitter_std_s == pytest.approx(5e-5, rel=0.1)


@pytest.mark.parametrize(('rate', 'rounded_s'), [(99.993, 1e-4), (425.083, 1e-3)])
def test_the_measured_rate_is_that_of_all_stamps(rate, rounded_s):
    stamps = np.arange(int(9 * rate)) / rate
    _, windows = run(pieces(samples(np.round(stamps / rounded_s) * rounded_s), 100))
    for channel in windows[-1].quality.channels:
        assert abs(channel.measured_rate_hz / rate - 1.0) < 2.0 * rounded_s / 9.0


def test_sensors_of_different_rate_and_phase_share_one_grid():
    block = blocks(9.0)
    first = samples(0.00037 + np.arange(3600) / 400.0, '/imu/a')
    second = samples(0.0041 + np.arange(9000) / 999.3, '/imu/b')
    stream = sorted(
        [*block, *pieces(first, 40), *pieces(second, 100)],
        key=lambda m: m.stamp_ns if isinstance(m, SampleBlock) else m.stamp_ns[0],
    )
    _, windows = run(stream)
    window = windows[1]
    assert window.samples.sample_rate_hz == 1000.0
    assert len(window.samples.channels) == 9
    assert error_of(window, [0, 1, 2, 0, 1, 2, 0, 1, 2]) < 2e-3


def test_reordered_within_a_second_gives_the_same_and_repeats_are_dropped():
    time_s = np.arange(9000) / 1000.0
    sent = samples(time_s)
    _, truth = run(pieces(sent, 100))
    rng = np.random.default_rng(3)
    order = np.argsort(np.arange(9000) + rng.uniform(0, 300, 9000))
    order = np.insert(order, 4000, order[3990:4000])
    shuffled = replace(sent, stamp_ns=sent.stamp_ns[order], acceleration=sent.acceleration[order])
    _, windows = run(pieces(shuffled, 100))
    assert sum(w.quality.channels[0].n_duplicates for w in windows[::2]) >= 1
    assert windows[0].quality.channels[0].n_reordered > 0
    for one, other in zip(truth[:2], windows[:2], strict=True):
        assert np.allclose(one.samples.acceleration, other.samples.acceleration, atol=1e-9)


def test_short_gaps_are_filled_and_counted():
    rng = np.random.default_rng(4)
    time_s = np.arange(9000) / 1000.0
    keep = rng.random(9000) > 0.01
    _, windows = run(pieces(samples(time_s[keep]), 100))
    lost = int(np.count_nonzero(~keep[2000:6000]))
    quality = windows[1].quality.channels[0]
    assert quality.n_interpolated == lost
    assert not quality.excluded and 'gap' in quality.flags
    assert error_of(windows[1], range(3)) < 0.05


def test_a_long_gap_of_one_sensor_excludes_it_and_others_go_on():
    time_s = np.arange(9000) / 1000.0
    broken = time_s[(time_s < 3.0) | (time_s > 3.4)]
    stream = sorted(
        [*pieces(samples(time_s), 100), *pieces(samples(broken, '/imu/b', 3), 100)],
        key=lambda m: m.stamp_ns[0],
    )
    _, windows = run(stream)
    names = {c.name: c for c in windows[0].quality.channels}
    assert not names['imu/a.x'].excluded
    assert names['imu/b.x'].excluded and 'lost' in names['imu/b.x'].flags
    assert names['imu/b.x'].n_lost == pytest.approx(400, abs=3)
    assert windows[0].samples.channel_names == ('imu/a.x', 'imu/a.y', 'imu/a.z')
    last = windows[2].samples
    assert last.start_ns - START == 4 * 10**9 and len(last.channels) == 6


def test_a_gap_of_all_sensors_splits():
    time_s = np.arange(12000) / 1000.0
    broken = time_s[(time_s < 5.0) | (time_s > 6.5)]
    buffer, windows = run(pieces(samples(broken), 100))
    assert buffer.counters.n_segments == 2 and buffer.counters.reasons == {'gap': 1}
    for window in windows:
        start = (window.samples.start_ns - START) * 1e-9
        end = (window.samples.end_ns - START) * 1e-9
        assert end <= 5.01 or start >= 6.49
        assert error_of(window, range(3)) < 2e-3


def test_lost_blocks_are_found_by_the_counter():
    sent = blocks(9.0)
    buffer, windows = run([*sent[:100], *sent[110:]])
    assert buffer.counters.reasons == {'gap': 1}
    assert windows[0].quality.channels[0].n_lost == 0
    assert all(not w.quality.channels[0].excluded for w in windows)


@pytest.mark.parametrize('value', [np.nan, np.inf, 1e300])
def test_bad_values_for_long_exclude_their_channel_only(value):
    sent = samples(np.arange(9000) / 1000.0)
    sent.acceleration[2400:2700, 1] = value
    _, windows = run(pieces(sent, 100))
    assert windows[0].samples.channel_names == ('imu/a.x', 'imu/a.z')
    assert 'not_finite' in windows[0].quality.channels[1].flags
    assert np.isfinite(windows[0].samples.acceleration).all()
    assert len(windows[2].samples.channels) == 3


def test_flatline_and_clipping_are_excluded():
    sent = samples(np.arange(9000) / 1000.0)
    sent.acceleration[:, 0] = 9.81
    sent.acceleration[:, 2] = sent.acceleration[:, 2].clip(-1.5, 1.5)
    _, windows = run(pieces(sent, 100))
    flags = [c.flags for c in windows[0].quality.channels]
    assert 'flatline' in flags[0] and 'clipping' in flags[2]
    assert windows[0].samples.channel_names == ('imu/a.y',)


def test_a_looped_bag_begins_a_new_segment_and_mixes_nothing():
    once = list(pieces(samples(np.arange(9000) / 1000.0), 100))
    buffer, windows = run([*once, *once])
    _, single = run(once)
    assert buffer.counters.reasons == {'clock_jump': 1}
    assert len(windows) == 2 * len(single)
    for one, other in zip(single, windows[len(single) :], strict=True):
        assert np.allclose(one.samples.acceleration, other.samples.acceleration, atol=1e-9)
    assert 'clock_jump' in windows[len(single)].quality.flags


def side_by_side(sensors, size):
    return [
        part for parts in zip(*(pieces(s, size) for s in sensors), strict=True) for part in parts
    ]


@pytest.mark.parametrize('size', [1, 25])
@pytest.mark.parametrize('back_s', [0.12, 0.5, 1.0])
def test_a_clock_set_back_by_a_second_or_less_begins_a_new_segment(back_s, size):
    """As one that is set back by more; what is then stamped again is no late message."""
    sensors = [samples(np.arange(4000) / 200.0, f'/imu/{place}', 9 * place) for place in range(3)]
    for each in sensors:
        each.stamp_ns[2100:] -= round(back_s * 1e9)
    buffer, windows = run(side_by_side(sensors, size))
    assert buffer.counters.reasons == {'clock_jump': 1}
    flags = {flag for w in windows for channel in w.quality.channels for flag in channel.flags}
    assert not flags & {'coarse_stamps', 'clock_unknown'}
    assert all(len(w.samples.channels) == 9 for w in windows)
    assert windows[-1].samples.end_ns - START == pytest.approx((20.0 - back_s) * 1e9, abs=1e7)


def test_one_sensor_set_back_costs_the_others_nothing():
    time_s = np.arange(4000) / 200.0
    sensors = [samples(time_s, f'/imu/{place}', 9 * place) for place in range(3)]
    _, whole = run(side_by_side(sensors[:2], 10))
    sensors[2].stamp_ns[2100:] -= 10**9
    _, windows = run(side_by_side(sensors, 10))
    # The record ends with the sensor that ends first.
    assert len(windows) >= len(whole) - 1
    for one, other in zip(windows, whole, strict=False):
        assert np.array_equal(one.samples.acceleration[:, :6], other.samples.acceleration)
    last = windows[-1].quality.channels[-1]
    assert 'clock_jump' in last.flags and not {'coarse_stamps', 'clock_unknown'} & {*last.flags}


@pytest.mark.parametrize('late_s', [0.2, 0.4])
def test_a_stretch_that_comes_late_fills_its_hole_and_one_that_comes_twice_is_dropped(late_s):
    sent = samples(np.arange(4000) / 200.0)
    _, whole = run(pieces(sent, 10))
    count = round(late_s * 200)
    late = np.r_[0:2000, 2000 + count : 2000 + 2 * count, 2000 : 2000 + count]
    twice = np.r_[0 : 2000 + 2 * count, 2000 + count : 2000 + 2 * count]
    for order in (late, twice):
        rows = np.r_[order, 2000 + 2 * count : 4000]
        arrived = replace(sent, stamp_ns=sent.stamp_ns[rows], acceleration=sent.acceleration[rows])
        buffer, windows = run(pieces(arrived, 10))
        assert not buffer.counters.reasons
        assert [w.samples.start_ns for w in windows] == [w.samples.start_ns for w in whole]
        for one, other in zip(windows, whole, strict=True):
            assert np.allclose(one.samples.acceleration, other.samples.acceleration, atol=1e-9)


def test_one_wild_stamp_does_no_harm():
    sent = samples(np.arange(9000) / 1000.0)
    sent.stamp_ns[3000] += 3600 * 10**9
    sent.stamp_ns[5000] -= 3600 * 10**9
    _, windows = run(pieces(sent, 100))
    assert len(windows) >= 3
    assert error_of(windows[0], range(3)) < 2e-2


def test_a_changed_rate_begins_a_new_segment():
    first = samples(np.arange(6000) / 1000.0)
    second = samples(6.0 + np.arange(3000) / 500.0)
    buffer, windows = run([*pieces(first, 100), *pieces(second, 50)])
    assert buffer.counters.reasons.get('rate_change') == 1
    assert {round(w.samples.sample_rate_hz) for w in windows} == {1000, 500}


def test_a_false_declared_rate_is_named():
    sent = [replace(b, sample_rate_hz=2000.0) for b in blocks(14.0)]
    _, windows = run(sent)
    reasons = [w.quality.reason for w in windows if not w.quality.identifiable]
    assert any('2000' in reason and '1000' in reason for reason in reasons)


def test_missing_channels_of_a_layout_are_named():
    layout = SensorLayout.from_mapping(
        {
            'sensors': [
                {'name': 'a', 'frame_id': 'link', 'topic': 'imu/a'},
                {'name': 'b', 'frame_id': 'link', 'topic': 'imu/b'},
            ]
        }
    )
    _, windows = run(pieces(samples(np.arange(5000) / 1000.0), 100), layout=layout)
    flags = {c.name: c.flags for c in windows[0].quality.channels}
    assert flags['b.x'] == ('missing',) and 'missing' not in flags['a.x']


def test_pose_of_a_window():
    stamps = START + np.arange(500, dtype=np.int64) * 10**7
    position = np.column_stack([np.linspace(0, 1, 500), np.full(500, -0.3)])
    joints = JointSamples(stamps, ('j1', 'j2'), position, np.zeros((500, 2)))
    _, windows = run([joints, *pieces(samples(np.arange(4500) / 1000.0), 100)])
    pose = windows[0].pose
    assert pose.joint_names == ('j1', 'j2')
    assert np.allclose(pose.position, position[:400].mean(axis=0))
    assert pose.position_range[1] == 0.0


def test_memory_is_bounded_by_the_window():
    buffer = SampleBuffer(SETTINGS)
    for part in pieces(samples(np.arange(60000) / 1000.0), 100):
        buffer.add(part)
        list(buffer.windows())
        assert buffer.n_held <= 7000 + 2500  # in their place, and waiting


@pytest.mark.parametrize('size', [1, 12, 100_000])
def test_bursts_of_samples_far_apart_are_taken_however_many(size):
    """A logger that is triggered: twelve samples every three seconds, a thousand times."""
    burst_s = 3.0 * np.arange(1000)[:, None] + 0.01 * np.arange(12)
    sent = samples(burst_s.ravel())
    stream = SourceStream(3)
    for part in pieces(sent, size):
        stream.add(part.stamp_ns, part.acceleration)
    np.testing.assert_array_equal(stream.samples().stamp_ns, sent.stamp_ns)
    assert not stream.set_aside


@pytest.mark.parametrize('since_s', [17.3, 20.0, 24.7])
def test_sensors_that_go_on_at_half_their_rate_end_a_segment_once(since_s):
    time_s = np.arange(0.0, 48.0, 1.0 / 128.0)
    rows = np.arange(len(time_s))
    kept = time_s[(time_s < since_s) | (rows % 2 == 0)]
    sensors = [samples(kept + 0.001 * place, f'/imu/{place}') for place in range(2)]
    parts = [part for pair in zip(*(pieces(s, 40) for s in sensors), strict=True) for part in pair]
    settings = IdentificationSettings(window_s=20.0, hop_s=10.0)
    buffer, windows = run(parts, settings)
    starts = [window.samples.start_ns for window in windows]
    assert starts == sorted(set(starts))
    assert buffer.counters.reasons['rate_change'] <= 2
    assert windows[-1].samples.sample_rate_hz == pytest.approx(64.0, rel=1e-3)


@pytest.mark.parametrize('first_s', [0.0, 0.01, 0.5, 1.0, 2.0, 2.5])
@pytest.mark.parametrize('size', [1, 250, 100_000])
def test_times_of_a_file_may_begin_anywhere(first_s, size):
    """They count from the trigger or the first sample, not from 1970."""
    sent = samples(np.arange(9000) / 1000.0)
    sent = replace(sent, stamp_ns=sent.stamp_ns - START + round(first_s * 1e9))
    buffer, windows = run(pieces(sent, size))
    assert len(windows) == 3
    assert not buffer.counters.reasons
    assert windows[0].samples.start_ns == round(first_s * 1e9)
    np.testing.assert_allclose(windows[0].samples.acceleration, sent.acceleration[:4000])
