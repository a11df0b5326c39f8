"""Held, stuffed, interpolated and frozen values are found; healthy ones are let alone."""

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.measurements import SampleBlock, StampedSamples
from oma_identifier.intake.sample_buffer import SampleBuffer
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.quality.repeats import RepeatWatch
from oma_identifier.settings import IdentificationSettings

START, RATE_HZ, SEED = 1_700_000_000_000_000_000, 200.0, 5
SETTINGS = IdentificationSettings(window_s=20.0, hop_s=20.0)
HZ = (9.0, 21.0, 34.0)


def responses(rng, n_channels=6, damping=0.01, noise=0.02, n=4400):
    """Modes at 9, 21 and 34 Hz under white forces."""
    out = np.zeros((n, n_channels))
    for hz in HZ:
        turn, r = 2 * np.pi * hz / RATE_HZ, np.exp(-damping * 2 * np.pi * hz / RATE_HZ)
        force = rng.standard_normal(n + 4000)
        mode = lfilter([1.0], [1.0, -2.0 * r * np.cos(turn), r * r], force)[4000:]
        out += np.outer(mode / mode.std(), rng.standard_normal(n_channels))
    return out + noise * out.std(axis=0) * rng.standard_normal(out.shape)


def identify(values, size=100, names=None):
    pipeline = IdentificationPipeline(SETTINGS)
    names = names or tuple(f'c{index}' for index in range(values.shape[1]))
    for first in range(0, len(values), size):
        stamp = START + round(first / RATE_HZ * 1e9)
        rows = values[first : first + size]
        pipeline.add(SampleBlock('/block', stamp, first, RATE_HZ, names, rows))
    return [pipeline.identify(window) for window in pipeline.windows()]


def held(values, times):
    return values[(np.floor(np.arange(len(values)) / times) * times).astype(int)]


def stuffed(values):
    changed = values.copy()
    changed[1::2] = 0.0
    return changed


def on_lines(values):
    changed = values.copy()
    changed[1:-1:2] = 0.5 * (values[:-2:2] + values[2::2])
    return changed


FAULTS = {
    'twice': lambda values: held(values, 2),
    'two or three times': lambda values: held(values, 2.5),
    'one in twenty twice': lambda values: held(values, 1.05),
    'zeros between': stuffed,
    'lines between': on_lines,
}


@pytest.mark.parametrize('fault', FAULTS)
def test_a_channel_without_new_values_takes_no_part(fault):
    values = responses(np.random.default_rng(SEED))
    values[:, 2] = FAULTS[fault](values)[:, 2]
    result = identify(values)[0]
    flags = [channel.flags for channel in result.quality.channels]
    assert 'sample_and_hold' in flags[2] and result.quality.channels[2].excluded
    assert not any(flags[:2] + flags[3:])
    # Held twice, a mode at f comes again at 100 Hz - f.
    for mode in result.modes:
        assert min(abs(mode.frequency_hz / hz - 1.0) for hz in HZ) < 0.02
    assert len(result.modes) == len(HZ)


def test_where_every_channel_is_held_the_reason_is_given():
    result = identify(held(responses(np.random.default_rng(SEED)), 2))[0]
    assert not len(result.modes) and 'values repeated instead of measured' in result.quality.reason


@pytest.mark.parametrize('size', [1, 37, 1000])
def test_held_values_are_found_in_samples_with_stamps_that_jitter(size):
    rng = np.random.default_rng(SEED)
    values = responses(rng, 3)
    values[:, 1] = held(values, 2)[:, 1]
    time_s = np.arange(len(values)) / RATE_HZ + rng.normal(0.0, 2e-4, len(values))
    stamps = START + np.round(time_s * 1e9).astype(np.int64)
    pipeline = IdentificationPipeline(SETTINGS)
    for first in range(0, len(values), size):
        rows = slice(first, first + size)
        pipeline.add(StampedSamples('/imu', 'link', stamps[rows], values[rows]))
    (window,) = pipeline.windows()
    assert ['sample_and_hold' in c.flags for c in window.quality.channels] == [False, True, False]


@pytest.mark.parametrize('n_still', [60, 200, 600])
def test_a_channel_that_freezes_takes_no_part(n_still):
    values = responses(np.random.default_rng(SEED))
    values[1000 : 1000 + n_still, 4] = values[1000, 4]
    result = identify(values)[0]
    flags = [channel.flags for channel in result.quality.channels]
    assert flags[4] == ('flatline',) and not any(flags[:4] + flags[5:])


def test_a_clock_that_is_set_back_does_not_bring_back_what_was_found():
    """A channel freezes just before the clock is set back; it is healthy at that time again."""
    values = responses(np.random.default_rng(SEED), 3, n=6000)
    frozen = values[:4440].copy()
    frozen[4020:4180, 1] = frozen[4020, 1]
    stamps = START + np.round(np.arange(len(values)) / RATE_HZ * 1e9).astype(np.int64)
    buffer = SampleBuffer(IdentificationSettings(window_s=5.0, hop_s=5.0))
    windows = []
    for sent in (frozen, values):
        for first in range(0, len(sent), 100):
            rows = slice(first, min(first + 100, len(sent)))
            buffer.add(StampedSamples('/imu', 'link', stamps[rows], sent[rows]))
            windows += buffer.windows()
    assert len(windows) == 4 + 5 and 'clock_jump' in windows[4].quality.flags
    assert not any('flatline' in c.flags for w in windows for c in w.quality.channels)


def test_healthy_channels_repeat_by_chance():
    """Converters of any step, tones, knocks, bursts, offsets: at most 1 in 1,200."""
    rng = np.random.default_rng(SEED)
    n_flagged = n_channels = 0
    for _ in range(40):
        values = responses(rng, 30, 10 ** rng.uniform(-3.5, -1.0), 10 ** rng.uniform(-3.0, 0.0))
        values *= 10 ** rng.uniform(-3.0, 1.0)
        kind = rng.integers(4)
        if kind == 1:
            values[: rng.integers(len(values))] *= 10 ** rng.uniform(-4.0, 0.0)
        elif kind == 2:
            values[rng.random(len(values)) < 0.01] *= 30.0
        elif kind == 3:
            tone = np.sin(2 * np.pi * rng.uniform(1.0, 90.0) * np.arange(len(values)) / RATE_HZ)
            values += 10.0 * values.std() * tone[:, None]
        step = values.std() * 2.0 ** rng.uniform(-16.0, -1.0)
        values = (step * np.rint(values / step) + 9.81 * rng.integers(2)).astype(np.float32)
        watch, stamps = RepeatWatch(30), np.arange(len(values)) * 5_000_000
        for first in range(0, len(values), 256):
            rows = slice(first, first + 256)
            watch.add(stamps[rows], values[rows].astype(float))
        found = watch.flags(0, int(stamps[-1]))
        n_channels += len(found)
        n_flagged += sum(map(bool, found))
    assert n_channels == 1200 and n_flagged <= 1, f'{n_flagged}, seed {SEED}'
