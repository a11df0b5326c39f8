"""Overflows, missing signs and reversed rows are found; whatever is healthy is let alone."""

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.measurements import SampleBlock
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.quality import ConverterWatch
from oma_identifier.settings import IdentificationSettings

START, RATE_HZ, SEED = 1_700_000_000_000_000_000, 200.0, 5
SETTINGS = IdentificationSettings(window_s=20.0, hop_s=20.0)
N_WINDOWS = 30
EXCITED = 1.0 / 60.0
"""Share of rows with a knock."""


def modes(rng, n=4400, n_channels=6, damping=0.01, hz=(9.0, 21.0, 34.0), knocks=False):
    """Structure under white forces, or under knocks."""
    out = np.zeros((n, n_channels))
    for each in hz:
        turn, decay = 2 * np.pi * each / RATE_HZ, np.exp(-damping * 2 * np.pi * each / RATE_HZ)
        force = rng.standard_normal(n + 4000)
        force *= rng.random(len(force)) < (EXCITED if knocks else 1.0)
        mode = lfilter([1.0, -2.0, 1.0], [1.0, -2.0 * decay * np.cos(turn), decay**2], force)
        out += np.outer(mode[4000:] / mode.std(), rng.standard_normal(n_channels))
    return out + 0.02 * out.std(axis=0) * rng.standard_normal(out.shape)


def tones(rng, low_hz, high_hz, n=4400):
    turns = np.outer(np.arange(n) / RATE_HZ, rng.uniform(low_hz, high_hz, 3))
    shape = rng.standard_normal((3, 6))
    return np.sin(2 * np.pi * turns) @ shape + 1e-3 * rng.standard_normal((n, 6))


def coarse(values, steps):
    size = values.std(axis=0) / steps
    return size * np.rint(values / size)


def identify(values, size=100):
    pipeline = IdentificationPipeline(SETTINGS)
    names = tuple(f'c{index}' for index in range(values.shape[1]))
    for first in range(0, len(values), size):
        stamp = START + round(first / RATE_HZ * 1e9)
        rows = values[first : first + size]
        pipeline.add(SampleBlock('/block', stamp, first, RATE_HZ, names, rows))
    return [pipeline.identify(window) for window in pipeline.windows()]


def wrapped(values, level):
    limit = level * values.std(axis=0)
    return (values + limit) % (2.0 * limit) - limit


def half_wave(values):
    return np.maximum(values, 0.0)


FAULTS = {
    'wraps often': ('wrapped', lambda values: wrapped(values, 1.6)),
    'wraps seldom': ('wrapped', lambda values: wrapped(values, 2.6)),
    'absolute': ('rectified', np.abs),
    'half wave': ('rectified', half_wave),
    'negative': ('rectified', lambda values: -np.abs(values)),
}


@pytest.mark.parametrize('fault', FAULTS)
@pytest.mark.parametrize('gravity', [False, True])
def test_a_converter_that_overflows_or_has_no_sign_is_left_out(fault, gravity):
    rng = np.random.default_rng(SEED)
    values = modes(rng)
    flag, change = FAULTS[fault]
    values[:, 2] = change(values)[:, 2]
    if gravity:
        values[:, [0, 4]] += 9.81 * np.sign(rng.standard_normal(2))
    channels = identify(values)[0].quality.channels
    assert [flag in channel.flags for channel in channels] == [n == 2 for n in range(6)], SEED
    assert [channel.excluded for channel in channels] == [n == 2 for n in range(6)]


@pytest.mark.parametrize('length', [8, 20, 50, 128])
def test_rows_reversed_within_blocks_take_no_part(length):
    values = modes(np.random.default_rng(SEED), n=4608)
    places = np.arange(4608) // length * length
    values = values[np.minimum(places + length - 1, 4607) - np.arange(4608) + places]
    result = identify(values)[0]
    assert all('rows_reversed' in channel.flags for channel in result.quality.channels), SEED
    assert not len(result.modes) and 'rows in reversed order in c0' in result.quality.reason


HEALTHY = {
    'modes': modes,
    'light damping': lambda rng: modes(rng, damping=2e-4, hz=rng.uniform(1.0, 99.0, 4)),
    'near half the rate': lambda rng: modes(rng, damping=1e-3, hz=rng.uniform(90.0, 99.9, 2)),
    'tones': lambda rng: tones(rng, 1.0, 99.0),
    'tones near half the rate': lambda rng: tones(rng, 95.0, 99.9),
    'coarse': lambda rng: coarse(modes(rng), rng.uniform(0.3, 20.0)),
    'quiet': lambda rng: np.rint(rng.uniform(0.2, 2.0) * rng.standard_normal((4400, 6))),
    'knocks': lambda rng: modes(rng, knocks=True),
    'gravity': lambda rng: rng.uniform(0.01, 9.0) * modes(rng) + 9.81,
    'one tone beside gravity': lambda rng: 9.81 * (tones(rng, 1.0, 99.0)[:, :3] + 1.0),
    'of no size': lambda rng: 1e-200 * modes(rng),
    'of any size': lambda rng: 10.0 ** rng.uniform(-90.0, 90.0) * modes(rng),
    'noise': lambda rng: rng.standard_normal((4400, 6)),
}


@pytest.mark.parametrize('kind', HEALTHY)
def test_healthy_channels_are_let_alone(kind):
    for seed in range(N_WINDOWS):
        values = HEALTHY[kind](np.random.default_rng(seed))
        watch = ConverterWatch(values.shape[1])
        stamps = START + np.arange(len(values)) * round(1e9 / RATE_HZ)
        for first in range(0, len(values), 256):
            watch.add(stamps[first : first + 256], values[first : first + 256])
        found = watch.flags(START, int(stamps[-1]) + 1)
        assert not any(found), (seed, found)


def test_what_was_found_is_forgotten_with_its_time():
    values = np.abs(modes(np.random.default_rng(SEED)))
    stamps = START + np.arange(len(values)) * round(1e9 / RATE_HZ)
    watch = ConverterWatch(values.shape[1])
    watch.add(stamps[:2048], values[:2048])
    watch.add(stamps[2048:4096], values[2048:4096] - 1.0)
    assert watch.flags(START, int(stamps[100]))[0] == ('rectified',)
    assert watch.flags(int(stamps[3000]), int(stamps[-1]))[0] == ()
    watch.forget(int(stamps[3000]))
    assert watch.flags(START, int(stamps[-1]))[0] == ()


def test_a_channel_of_both_signs_has_a_sign_whatever_a_stretch_of_it_looks_like():
    """Few slow swings beside an offset may end at zero; the next ones go beyond."""
    values = modes(np.random.default_rng(SEED))
    values[:2048] = np.abs(values[:2048])
    stamps = START + np.arange(len(values)) * round(1e9 / RATE_HZ)
    alone, whole = (ConverterWatch(values.shape[1]) for _ in range(2))
    alone.add(stamps[:2048], values[:2048])
    whole.add(stamps, values)
    assert alone.flags(START, int(stamps[2047])) == [('rectified',)] * values.shape[1]
    assert whole.flags(START, int(stamps[-1])) == [()] * values.shape[1]


def test_a_watch_sees_every_sample_once_and_nothing_across_lost_ones():
    """Blocks end anywhere beside the stretches of the grid; a gap is no leap of a converter."""
    rng = np.random.default_rng(40)
    for rate_hz, n_block in ((72.0, 100), (155.0, 64), (1000.0 / 3.0, 37)):
        time = np.arange(int(90 * rate_hz)) / rate_hz
        lines = rng.uniform(0.05, 0.4, 5) * rate_hz
        rows = np.sin(2 * np.pi * time[:, None] * lines).sum(axis=1, keepdims=True)
        rows = rows + 0.01 * rng.standard_normal(rows.shape)
        for lost in (0, 7):
            pipeline = IdentificationPipeline(IdentificationSettings(window_s=30.0))
            for first in range(0, len(rows), n_block):
                index = first + lost * (first > len(rows) // 2)
                part = rows[index : index + n_block]
                stamp_ns = 10**18 + round(index * 1e9 / rate_hz)
                pipeline.add(SampleBlock('a', stamp_ns, index, rate_hz, ('x',), part))
            windows = [*pipeline.windows(), *pipeline.finish()]
            flags = {flag for each in windows for c in each.quality.channels for flag in c.flags}
            assert not flags & {'wrapped', 'rectified', 'rows_reversed'}, (rate_hz, lost, flags)
