"""Stamps coarser than the samples: the clock is rebuilt by counting, or the sensor left out."""

import numpy as np
import pytest

from modal_core.measurements import SampleBlock, StampedSamples
from oma_identifier.intake.sample_buffer import SampleBuffer
from oma_identifier.settings import IdentificationSettings

START, SEED = 1_700_000_000_000_000_000, 3
SETTINGS = IdentificationSettings(window_s=8.0, hop_s=8.0)


def tones(time_s, rate_hz):
    hz = rate_hz * np.array([0.031, 0.117, 0.26, 0.33])
    return np.sin(2 * np.pi * time_s[:, None, None] * hz + np.arange(3)[:, None]).sum(axis=2)


def ticks(tick_s):
    return lambda time_s, rng: np.floor(time_s / tick_s + 1e-9) * tick_s


def buffers(depth, late_s):
    def stamps(time_s, rng):
        rows = np.arange(len(time_s)) // depth
        last = np.minimum(rows * depth + depth - 1, len(time_s) - 1)
        return time_s[last] + rng.uniform(0.0, late_s, rows[-1] + 1)[rows]

    return stamps


def windows_of(time_s, stamp_s, rate_hz, size=50):
    buffer = SampleBuffer(SETTINGS)
    stamps = START + np.round(stamp_s * 1e9).astype(np.int64)
    values = tones(time_s, rate_hz)
    for first in range(0, len(time_s), size):
        rows = slice(first, first + size)
        buffer.add(StampedSamples('/imu', 'link', stamps[rows], values[rows]))
    return [*buffer.windows(), *buffer.finish()]


CASES = {
    '10 ms at 200 Hz': (200.0, ticks(0.01)),
    'ten samples per stamp': (200.0, buffers(10, 1e-3)),
    'whole milliseconds at 5.2 ms': (1 / 0.0052, ticks(0.001)),
    '4 ms at 5 ms': (200.0, ticks(0.004)),
    '15.625 ms at 104 Hz': (104.0, ticks(0.015625)),
}


@pytest.mark.slow
@pytest.mark.parametrize('case', CASES)
@pytest.mark.parametrize('size', [1, 50])
def test_samples_of_coarse_stamps_keep_their_times(case, size):
    rate_hz, stamps = CASES[case]
    time_s = 0.0003 + np.arange(int(17 * rate_hz)) / rate_hz
    rng = np.random.default_rng(SEED)
    windows = windows_of(time_s, stamps(time_s, rng), rate_hz, size)
    data = windows[0].samples
    (quality, *_) = windows[0].quality.channels
    assert quality.measured_rate_hz == pytest.approx(rate_hz, rel=2e-3), f'seed {SEED}'
    assert not quality.excluded and quality.n_duplicates == 0
    if 'milliseconds' not in case:
        assert 'coarse_stamps' in quality.flags
    at_s = (data.start_ns - START) * 1e-9 + np.arange(len(data.acceleration)) / data.sample_rate_hz
    # One constant delay is left, half a tick or the time of reading out at most; images are not.
    errors = [
        np.abs(data.acceleration - tones(at_s + delay, rate_hz))[100:-100].std()
        for delay in np.linspace(-0.055, 0.055, 2201)
    ]
    assert min(errors) < 0.05, f'{min(errors)}'


def test_a_sample_that_is_lost_among_coarse_stamps_is_no_silent_shift():
    time_s = np.delete(np.arange(3400) / 200.0, 900)
    windows = windows_of(time_s, ticks(0.01)(time_s, None), 200.0)
    assert 'clock_unknown' in windows[0].quality.channels[0].flags
    assert windows[0].quality.channels[0].excluded


@pytest.mark.parametrize('declared_hz', [198.0, 200.5, 199.7])
def test_a_rate_a_little_off_is_refused_with_both_rates(declared_hz):
    (*_, window) = windows_of_blocks(declared_hz, 0.0005, 0.0)
    assert not window.quality.identifiable and 'rate_mismatch' in window.quality.flags
    assert f'{declared_hz:g}' in window.quality.reason and ' 200' in window.quality.reason


def test_a_recorder_whose_rate_is_wrong_is_left_out_and_the_others_are_identified():
    rng, buffer = np.random.default_rng(SEED), SampleBuffer(SETTINGS)
    for first in range(0, 4800, 20):
        time_s = np.arange(first, first + 20) / 200.0
        late_ns = round(1e9 * rng.exponential(0.0005))
        stamps = START + np.round(time_s * 1e9).astype(np.int64)
        values = tones(time_s, 200.0)
        noise = rng.normal(size=(20, 2))
        buffer.add(StampedSamples('/imu', 'link', stamps, values))
        buffer.add(
            SampleBlock('/block', int(stamps[0]) + late_ns, first, 190.0, ('k', 'l'), noise)
        )
    (*_, window) = [*buffer.windows(), *buffer.finish()]
    assert window.quality.identifiable and 'rate_mismatch' in window.quality.flags
    left_out = {one.name: one.flags for one in window.quality.channels if one.excluded}
    assert set(left_out) == {'k', 'l'} and 'rate_mismatch' in left_out['k']
    assert len(window.samples.channels) == 3


@pytest.mark.parametrize(('declared_hz', 'step_s'), [(200.0, 0.0), (200.06, 0.0), (200.0, 0.05)])
def test_crystals_and_steps_of_the_host_clock_are_no_other_rate(declared_hz, step_s):
    for window in windows_of_blocks(declared_hz, 0.003, step_s):
        assert window.quality.identifiable


def windows_of_blocks(declared_hz, late_s, step_s):
    """24 s of blocks at 200 Hz, stamped late by chance, the host's clock stepping midway."""
    rng, buffer = np.random.default_rng(SEED), SampleBuffer(SETTINGS)
    names = ('a', 'b', 'c')
    for first in range(0, 4800, 20):
        time_s = np.arange(first, first + 20) / 200.0
        stamp_s = time_s[0] + rng.exponential(late_s) + step_s * (first > 2400)
        stamp = START + round(stamp_s * 1e9)
        buffer.add(SampleBlock('/block', stamp, first, declared_hz, names, tones(time_s, 200.0)))
    return [*buffer.windows(), *buffer.finish()]
