"""Samples that never came: short gaps are bridged, long ones split, and what is left says so."""

import numpy as np
import pytest

from modal_core.measurements import SampleBlock, StampedSamples
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings
from oma_identifier.time_axis.resample import fill_gaps

START = 1_700_000_000_000_000_000
SEED = 17
RATE_HZ = 200.0
FREQUENCY_HZ = (6.0, 14.0, 31.0)
DAMPING = (0.02, 0.015, 0.02)


def stamps_of(rows):
    return START + np.round(rows / RATE_HZ * 1e9).astype(np.int64)


def sent(data, kept, source):
    """Per-sample messages of three channels, in batches of a quarter of a second."""
    rows = np.flatnonzero(kept)
    return [
        StampedSamples(source, 'link', stamps_of(part), data[part])
        for part in np.split(rows, np.searchsorted(rows, np.arange(50, len(data), 50)))
        if len(part)
    ]


def bursts(rng, n_rows, share, length):
    kept = np.ones(n_rows, dtype=bool)
    for start in rng.integers(length, n_rows - 2 * length, round(share * n_rows / length)):
        kept[start : start + length] = False
    return kept


def identified(messages, window_s):
    pipeline = IdentificationPipeline(IdentificationSettings(window_s=window_s))
    windows = []
    for message in sorted(messages, key=lambda m: np.min(m.stamp_ns)):
        pipeline.add(message)
        windows += pipeline.windows()
    windows += pipeline.finish()
    return windows, [pipeline.identify(window) for window in windows], pipeline


def check(modes, deviations=3.0):
    """Each true mode is there, as near as its deviation says."""
    for hz, zeta in zip(FREQUENCY_HZ, DAMPING, strict=True):
        mode = min(modes, key=lambda mode: abs(mode.frequency_hz - hz))
        assert abs(mode.frequency_hz - hz) < deviations * mode.frequency_std_hz, f'seed {SEED}'
        assert abs(mode.damping_ratio - zeta) < deviations * mode.damping_ratio_std
        assert mode.frequency_std_hz < 0.01 * hz


@pytest.fixture
def responses(structure):
    def make(duration_s):
        true = structure(FREQUENCY_HZ, DAMPING, n_channels=6, seed=SEED)
        rng = np.random.default_rng(SEED)
        return true.simulate(rng, duration_s, RATE_HZ).acceleration

    return make


@pytest.mark.parametrize('length', [1, 5, 20])
def test_a_record_with_bursts_of_lost_samples_gives_its_modes(responses, length):
    data = responses(60.0)
    kept = bursts(np.random.default_rng(SEED), len(data), 0.008, length)
    messages = [*sent(data[:, :3], kept, '/a'), *sent(data[:, 3:], kept, '/b')]
    windows, results, pipeline = identified(messages, 60.0)
    assert len(windows) == 1 and len(windows[0].samples.channels) == 6
    assert 'gap' not in pipeline.buffer.counters.reasons
    quality = windows[0].quality.channels[0]
    assert quality.n_interpolated == pytest.approx(np.count_nonzero(~kept), abs=2)
    assert 'gap' in quality.flags
    check(results[0].modes)


def test_a_recorder_that_loses_short_blocks_gives_its_modes(responses):
    data = responses(60.0).astype(np.float32)
    names = tuple(f'c{n}' for n in range(6))
    rng = np.random.default_rng(SEED)
    messages = [
        SampleBlock('/b', int(stamps_of(first)), first, RATE_HZ, names, data[first : first + 10])
        for first in range(0, len(data), 10)
        if rng.random() > 0.02
    ]
    windows, results, _ = identified(messages, 60.0)
    assert len(windows) == 1 and 'degraded' in windows[0].quality.flags
    check(results[0].modes)


def test_half_of_all_samples_lost_costs_no_mode_and_says_so(responses):
    # A dense solution of these gaps took minutes.
    data = responses(20.0)
    kept = np.random.default_rng(SEED).random(len(data)) > 0.5
    messages = [*sent(data[:, :3], kept, '/a'), *sent(data[:, 3:], kept, '/b')]
    windows, results, _ = identified(messages, 20.0)
    assert windows[0].samples.sample_rate_hz == pytest.approx(RATE_HZ, rel=1e-3)
    assert 'degraded' in results[0].quality.flags
    found = np.array([mode.frequency_hz for mode in results[0].modes])
    assert all(np.abs(found / hz - 1.0).min() < 0.02 for hz in FREQUENCY_HZ)


@pytest.mark.parametrize('share', [0.1, 0.4])
def test_damping_from_many_filled_samples_states_no_deviation(responses, share):
    data = responses(20.0)
    kept = np.random.default_rng(SEED).random(len(data)) > share
    _, results, pipeline = identified([*sent(data[:, :3], kept, '/a')], 20.0)
    for result in (results[0], pipeline.whole()):
        assert len(result.modes) >= len(FREQUENCY_HZ)
        assert ('damping_unsure' in result.quality.flags) == (share > 0.2)
        known = [np.isfinite(mode.damping_ratio_std) for mode in result.modes]
        assert all(known) if share < 0.2 else not any(known), SEED
        assert all(np.isfinite(mode.frequency_std_hz) for mode in result.modes)


def test_a_sensor_that_loses_samples_costs_the_others_nothing(responses):
    data = responses(20.0)
    whole = np.ones(len(data), dtype=bool)
    kept = bursts(np.random.default_rng(SEED), len(data), 0.05, 30)
    kept[1500:1700] = False
    one, _, _ = identified([*sent(data[:, :3], whole, '/a')], 20.0)
    both, _, _ = identified(
        [*sent(data[:, :3], whole, '/a'), *sent(data[:, 3:], kept, '/b')], 20.0
    )
    assert len(both) == len(one)
    flags = {c.name: c.flags for c in both[0].quality.channels}
    assert 'lost' in flags['b.x'] and 'gap' not in flags['a.x']
    assert np.array_equal(one[0].samples.acceleration, both[0].samples.acceleration)


@pytest.mark.parametrize('value', [np.nan, np.inf, -1e30])
@pytest.mark.parametrize('begin', [1190, 3000, 4391])
def test_values_that_are_no_numbers_for_a_while_are_a_gap_of_their_channel(
    responses, value, begin
):
    # At 1190 and 4391 they lie across the ends of stretches of a second.
    data = responses(60.0)
    whole = np.ones(len(data), dtype=bool)
    healthy, expected, _ = identified([*sent(data[:, :3], whole, '/a')], 60.0)
    broken = data.copy()
    broken[begin : begin + 20, 1] = value
    windows, results, _ = identified([*sent(broken[:, :3], whole, '/a')], 60.0)
    assert len(windows) == 1 and windows[0].samples.channel_names == ('a.x', 'a.y', 'a.z')
    counted = [(c.n_interpolated, c.n_lost, 'gap' in c.flags) for c in windows[0].quality.channels]
    assert counted == [(0, 0, False), (20, 20, True), (0, 0, False)]
    others = [0, 2]
    own, same = (w[0].samples.acceleration for w in (windows, healthy))
    assert np.array_equal(own[:, others], same[:, others])
    error = own[begin - 2 : begin + 22, 1] - same[begin - 2 : begin + 22, 1]
    assert np.sqrt(np.mean(error**2)) < 0.7 * same[:, 1].std(), f'seed {SEED}'
    check(results[0].modes)
    for mode, true in zip(results[0].modes, expected[0].modes, strict=True):
        assert abs(mode.frequency_hz - true.frequency_hz) < true.frequency_std_hz
        assert abs(mode.damping_ratio - true.damping_ratio) < true.damping_ratio_std


def test_short_runs_of_no_numbers_take_a_channel_out_where_they_are_many(responses):
    data = responses(60.0)
    blocks = [data[first : first + 50].copy() for first in range(0, len(data), 50)]
    for block in blocks[::4]:
        block[10:25, 1] = np.nan
    names = tuple(f'c{n}' for n in range(6))
    messages = [
        SampleBlock('/b', int(stamps_of(50 * n)), 50 * n, RATE_HZ, names, block)
        for n, block in enumerate(blocks)
    ]
    windows, results, _ = identified(messages, 60.0)
    assert 'not_finite' in windows[0].quality.channels[1].flags
    assert windows[0].samples.channel_names == ('c0', 'c2', 'c3', 'c4', 'c5')
    check(results[0].modes)


def test_a_record_cut_by_long_gaps_is_identified_from_its_stretches(responses):
    data = responses(120.0)
    kept = np.ones(len(data), dtype=bool)
    for start in range(3000, len(data), 3000):
        kept[start : start + 300] = False
    messages = [*sent(data[:, :3], kept, '/a'), *sent(data[:, 3:], kept, '/b')]
    windows, _, pipeline = identified(messages, 60.0)
    assert pipeline.buffer.counters.reasons['gap'] == 7
    assert all('partial' in window.quality.flags for window in windows)
    check(pipeline.whole().modes)


@pytest.mark.parametrize('length', [1, 7, 40, 200])
def test_gaps_are_filled_by_what_surprises_least(length):
    """The filled samples are stationary: no change of them lowers the prediction error."""
    rng = np.random.default_rng(SEED)
    time = np.arange(1500)
    signal = np.sin(0.21 * time) + 0.5 * np.sin(0.83 * time + 1.0) + 0.01 * rng.normal(size=1500)
    missing = ~bursts(rng, 1500, 0.2, length)
    filled = fill_gaps(np.where(missing, 7.0, signal)[:, None], missing)[:, 0]
    assert np.array_equal(filled[~missing], signal[~missing])
    error = np.sqrt(np.mean((filled - signal)[missing] ** 2))
    assert error < 0.1 * signal.std(), f'seed {SEED}'


@pytest.mark.parametrize('as_blocks', [False, True])
def test_placeholders_of_lost_samples_are_as_if_these_had_not_come(responses, as_blocks):
    """A pause of all channels splits the record; what one lost for a moment is filled in."""
    data = responses(24.0)[:, :3]
    rows = np.arange(len(data))
    written = data.copy()
    paused = (rows >= 2000) & (rows < 2600)
    lost = np.isin(rows, [400, 401, 1130, 1131, 3333])
    written[paused] = 9999.0
    written[lost, 1] = 9999.0

    def windows(data, kept):
        messages = sent(data, kept, 'imu')
        if as_blocks:
            names = tuple('xyz')
            messages = [
                SampleBlock('daq', START + round(i / RATE_HZ * 1e9), i, RATE_HZ, names, part)
                for i, part in zip(rows[::50], np.split(data, rows[50::50]), strict=True)
            ]
        pipeline = IdentificationPipeline(IdentificationSettings(window_s=8.0))
        for message in messages:
            pipeline.add(message)
        return [*pipeline.windows(), *pipeline.finish()]

    found = windows(written, np.ones(len(data), dtype=bool))
    far = {each[1:] for window in found for each in window.quality.channels[1].far_values}
    assert {value for value, _ in far} == {9999.0}
    assert all(np.abs(window.samples.acceleration).max() < 100.0 for window in found)
    assert len(found) > 1
    assert not any('not_finite' in each.flags for w in found for each in w.quality.channels)
