"""A record as one: its length planned for, refined, with gaps, beyond its memory, drifting."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from autonomous_modal_analysis import identify
from modal_core.measurements import SampleBlock
from oma_identifier.identify import identify_samples
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.record import whole_record
from oma_identifier.settings import IdentificationSettings

RATE_HZ, SEED = 64.0, 33
TRUTH_HZ = (1.2, 4.0, 9.0, 9.4, 21.0)
DAMPING = (0.015, 0.02, 0.015, 0.02, 0.03)


def identified(samples, gaps_s=(), settings=None):
    """Return the windows and the whole of a record that came in blocks, but for some."""
    pipeline = IdentificationPipeline(settings or IdentificationSettings())
    size, rate_hz = int(samples.sample_rate_hz), samples.sample_rate_hz
    windows = []
    for first in range(0, len(samples.acceleration), size):
        if any(begin <= first / rate_hz < end for begin, end in gaps_s):
            continue
        rows = samples.acceleration[first : first + size].astype(np.float32)
        stamp_ns = 10**18 + round(first / rate_hz * 1e9)
        names = samples.channel_names
        pipeline.add(SampleBlock('blocks', stamp_ns, first, rate_hz, names, rows))
        windows += [pipeline.identify(window) for window in pipeline.windows()]
    windows += [pipeline.identify(window) for window in pipeline.finish()]
    return windows, pipeline.whole()


def values(modes):
    return np.array([(m.frequency_hz, m.damping_ratio) for m in modes])


def deviations(modes):
    return np.array([(m.frequency_std_hz, m.damping_ratio_std) for m in modes])


def n_refined(modes):
    """Return how many modes were refined: only these have deviations of their shapes."""
    return sum(mode.shape_std is not None for mode in modes)


def assert_true(modes, hz=TRUTH_HZ, damping=DAMPING, most=4.0):
    assert len(modes) == len(hz), modes.frequency_hz
    away = (values(modes) - np.column_stack([hz, damping])) / deviations(modes)
    assert np.all(np.abs(away) < most), away


@pytest.fixture
def record(structure):
    return structure(TRUTH_HZ, DAMPING).simulate(np.random.default_rng(SEED), 240.0, RATE_HZ)


def test_the_headline_is_the_record_refined_whoever_asks(record):
    """Recording, array and stretch give the same modes, with deviations of their shapes."""
    alone = identify_samples(record).modes
    _, whole = identified(record)
    array = identify(record.acceleration, RATE_HZ).found.whole
    assert_true(alone)
    for found in (whole.modes, array.modes):
        apart = (values(found) - values(alone)) / deviations(alone)
        assert np.abs(apart).max() < 0.02, apart
        np.testing.assert_allclose(deviations(found), deviations(alone), rtol=0.01)
        assert n_refined(found) >= 4


def test_it_is_refined_though_windows_follow_too_fast_for_that(record):
    windows, whole = identified(record, settings=IdentificationSettings(hop_s=4.0))
    assert not any(n_refined(window.modes) for window in windows)
    assert n_refined(whole.modes) >= 4
    _, plain = identified(record, settings=IdentificationSettings(refine=False))
    assert n_refined(plain.modes) == 0


def test_a_slow_structure_at_a_low_rate_shows_its_lowest_mode():
    """Five storeys at 12 Hz for 20 minutes: a window of 60 s holds 11 periods of the lowest."""
    stiffness = 2.0 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1)
    stiffness[-1, -1] = 1.0
    squares, shapes = np.linalg.eigh(stiffness)
    hz = 0.18 * np.sqrt(squares / squares[0])
    rng = np.random.default_rng(7)
    rows = _driven(rng, hz[:, None], 0.01, shapes, 12.0, 1200.0)
    found = identify(rows, 12.0).found.whole
    assert_true(found.modes, hz, np.full(5, 0.01))
    assert 'windows_too_short' in found.quality.flags


def test_a_record_tells_what_is_too_slow_for_every_window(record):
    """30 periods of the band asked for are longer than a window: none can be identified."""
    result = identify(record.acceleration, RATE_HZ, max_frequency_hz=2.0, window_s=14.0)
    assert not any(window.quality.identifiable for window in result.found.identification.windows)
    assert_true(result.found.whole.modes, TRUTH_HZ[:1], DAMPING[:1])
    assert {'windows_too_short', 'few_windows'} <= set(result.found.whole.quality.flags)
    assert sum(part.duration_s for part in result.found.parts) == pytest.approx(240.0)


def test_gaps_cost_what_is_missing_and_no_more(record):
    """Three stretches of 80, 60 and 70 s: all lines of their spectra count.

    Of 8 draws of five modes 29 are refined with gaps and 30 without, no draw two fewer.
    """
    _, whole = identified(record)
    _, parts = identified(record, gaps_s=((80.0, 90.0), (150.0, 170.0)))
    assert 'gap' in parts.quality.flags
    assert_true(parts.modes)
    wider = deviations(parts.modes) / deviations(whole.modes)
    assert np.median(wider) == pytest.approx(np.sqrt(240.0 / 210.0), rel=0.1)
    assert n_refined(parts.modes) >= n_refined(whole.modes) - 1


@pytest.mark.parametrize('most_bytes', [pytest.param(250_000, marks=pytest.mark.slow), 50_000])
def test_beyond_its_memory_high_modes_are_from_the_windows(record, monkeypatch, most_bytes):
    """The samples are kept at 16 and 4 Hz; the lowest mode is below what a window sees surely."""
    _, whole = identified(record)
    monkeypatch.setattr(whole_record, 'MOST_BYTES', most_bytes)
    _, bounded = identified(record)
    assert_true(bounded.modes)
    assert len(bounded.modes) == len(whole.modes)
    apart = (values(bounded.modes) - values(whole.modes)) / deviations(whole.modes)
    assert np.abs(apart).max() < 2.5, apart
    np.testing.assert_allclose(deviations(bounded.modes), deviations(whole.modes), rtol=0.8)
    assert bounded.poles.frequency_hz.max() > 25.0
    numbers = bounded.poles.mode_id
    for number, mode in enumerate(bounded.modes, start=1):
        own = bounded.poles.frequency_hz[numbers == number]
        assert np.all(np.abs(own / mode.frequency_hz - 1.0) < 0.1), mode.frequency_hz


@pytest.mark.parametrize('drift', [0.0, 0.02])
def test_windows_that_disagree_widen_the_deviation_and_are_named(drift):
    rng = np.random.default_rng(3)
    hz = np.outer((5.0, 11.0), 1.0 + drift * np.linspace(-0.5, 0.5, 30_000))
    rows = _driven(rng, hz, 0.01, rng.standard_normal((4, 2)), 50.0, 600.0)
    whole = identify(rows, 50.0).found.whole
    assert_true(whole.modes, (5.0, 11.0), (0.01, 0.01))
    assert ('modes_vary' in whole.quality.flags) == (drift > 0.0)
    if drift:
        scatter = drift / np.sqrt(12.0) * np.array((5.0, 11.0))
        np.testing.assert_allclose(deviations(whole.modes)[:, 0], scatter, rtol=0.5)


@pytest.mark.parametrize('drift', [0.0, 0.02])
def test_a_record_of_one_window_tells_by_its_quarters_that_a_mode_drifts(drift):
    """Half-widths are 0.5 %: what drifts by 2 % seems to be damped thrice as much."""
    rng = np.random.default_rng(4)
    hz = np.outer((21.0, 44.0), 1.0 + drift * np.linspace(-0.5, 0.5, 9000))
    rows = _driven(rng, hz, 0.005, rng.standard_normal((4, 2)), 150.0, 60.0)
    whole = identify(rows, 150.0).found.whole
    assert ('modes_vary' in whole.quality.flags) == (drift > 0.0)
    off = np.abs(whole.modes.frequency_hz - (21.0, 44.0)) / deviations(whole.modes)[:, 0]
    assert np.all(off < 3.0), off
    if drift:
        scatter = drift / np.sqrt(12.0) * np.array((21.0, 44.0))
        assert np.all(deviations(whole.modes)[:, 0] > 0.6 * scatter)
        # Within a quarter they move by their half-width still: damping is hardly known.
        off = np.abs(values(whole.modes)[:, 1] - 0.005) / deviations(whole.modes)[:, 1]
        assert np.all(np.isnan(off) | (off < 3.0)) and np.isnan(off).any(), off


def test_a_mode_that_drifts_by_many_half_widths_is_one_of_the_quarters():
    """20 half-widths over the record, 5 in a quarter: the record as one shows a ridge, no mode."""
    rng = np.random.default_rng(5)
    drift = 1.0 + 0.02 * np.linspace(-0.5, 0.5, 16_800)
    hz = np.array((21.0, 44.0))
    rows = _driven(rng, np.outer(hz, drift), 0.001, rng.standard_normal((4, 2)), 140.0, 120.0)
    whole = identify(rows, 140.0).found.whole
    assert 'modes_vary' in whole.quality.flags
    assert len(whole.modes) == 2, whole.modes
    off = np.abs(whole.modes.frequency_hz - hz) / deviations(whole.modes)[:, 0]
    assert np.all(off < 3.0), off
    assert np.all(deviations(whole.modes)[:, 0] > 0.6 * 0.02 / np.sqrt(12.0) * hz)
    assert np.isnan(deviations(whole.modes)[:, 1]).all()


def test_gravity_costs_no_digits(record):
    """Micrometres per second squared on gravity: about zero, single precision is coarser."""
    quiet = replace(record, acceleration=1e-6 * record.acceleration + 9.81)
    found = identify(quiet.acceleration, RATE_HZ).found.whole.modes
    plain = identify(record.acceleration, RATE_HZ).found.whole.modes
    np.testing.assert_allclose(values(found), values(plain), rtol=1e-3)


def _driven(rng, frequency_hz, damping, shapes, rate_hz, duration_s):
    """Return rows of modes of any frequency over time, each shaken by its own white force."""
    n_rows = int(rate_hz * duration_s)
    rows = np.zeros((n_rows, len(shapes)))
    for hz, shape in zip(np.atleast_2d(frequency_hz), shapes.T, strict=True):
        force = rng.standard_normal(n_rows)
        angle = 2.0 * np.pi * hz / rate_hz
        radius = np.exp(-damping * angle)
        once, twice = 2.0 * radius * np.cos(angle * np.sqrt(1.0 - damping**2)), -(radius**2)
        if len(hz) == 1:
            moved = lfilter([1.0], [1.0, -once[0], -twice[0]], force)
        else:
            moved = force
            for row in range(2, n_rows):
                moved[row] += once[row] * moved[row - 1] + twice[row] * moved[row - 2]
        rows += np.outer(moved / moved.std(), shape)
    return rows + 0.05 * rows.std() * rng.standard_normal(rows.shape)
