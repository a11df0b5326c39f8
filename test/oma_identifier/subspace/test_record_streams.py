"""A sliding window and a whole record against the plain identification of the same samples."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.quality import DataQuality
from modal_core.samples import Samples
from oma_identifier.covariance.bands import plan_bands
from oma_identifier.covariance.condition import Decimation
from oma_identifier.covariance.output_covariance import (
    CovarianceAccumulator,
    lagged_products,
    WhenFull,
)
from oma_identifier.identify import identify_bands, identify_samples
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra.harmonics import line_at
from oma_identifier.spectra.spectrum import singular_value_spectrum
from oma_identifier.subspace.record_streams import RecordStreams
from oma_identifier.whole_record import WholeRecord

RATE_HZ = 64.0
SETTINGS = IdentificationSettings(window_s=60.0, hop_s=5.0, refine=False)


@pytest.fixture
def record(structure):
    known = structure((3.0, 8.0, 8.3, 20.0), (0.02, 0.015, 0.02, 0.03))
    return known.simulate(np.random.default_rng(11), 180.0, RATE_HZ)


def window(record, start_s, length_s=60.0):
    first, last = round(start_s * RATE_HZ), round((start_s + length_s) * RATE_HZ)
    return Samples(record.acceleration[first:last], RATE_HZ, record.channels, round(start_s * 1e9))


def test_lagged_products_are_exact():
    rng = np.random.default_rng(12)
    for n_channels in (3, 15):
        rows, past = rng.standard_normal((50, n_channels)), rng.standard_normal((7, n_channels))
        data, references = np.concatenate([past, rows]), np.array([0, 2])
        expected = [
            sum(np.outer(data[t], data[t - lag, references]) for t in range(7, 57))
            for lag in range(1, 8)
        ]
        np.testing.assert_allclose(lagged_products(rows, past, references), expected, atol=1e-10)


@pytest.mark.parametrize('when_full', WhenFull)
def test_chunks_do_not_matter(when_full):
    rng = np.random.default_rng(13)
    rows = rng.standard_normal((2000, 4))
    make = [CovarianceAccumulator(9, np.arange(4), 50, 16, when_full) for _ in range(2)]
    make[0].add(rows)
    for chunk in np.split(rows, [3, 50, 51, 777, 778, 1500]):
        make[1].add(chunk)
    one, many = (each.result(1.0) for each in make)
    np.testing.assert_allclose(one.blocks, many.blocks, atol=1e-12)
    kept = 800 if when_full is WhenFull.RETIRE else 2000 - 2000 % make[0].block_samples
    tail = rows[-800:] if when_full is WhenFull.RETIRE else rows[:kept]
    assert one.n_samples == kept
    lag = one.mean[2]
    plain = tail[3:].T @ tail[:-3] / (len(tail) - 3)
    np.testing.assert_allclose(lag, plain, atol=0.03)


def test_sliding_window_sees_what_a_single_window_sees(record):
    streams = RecordStreams(SETTINGS, WhenFull.RETIRE)
    for start_s in range(0, 61, 5):
        streams.add(window(record, start_s))
    last = window(record, 60.0)
    slid = identify_bands(
        streams.results(), record.channels, SETTINGS, lambda hz: line_at(last, hz)
    )
    alone = identify_samples(last, SETTINGS)
    assert len(slid.modes) == len(alone.modes) == 4
    difference = np.abs(slid.modes.frequency_hz - alone.modes.frequency_hz)
    deviation = np.array([mode.frequency_std_hz for mode in alone.modes])
    assert np.all(difference < 0.7 * deviation), difference / deviation


def test_gap_starts_the_window_anew(record):
    streams = RecordStreams(SETTINGS, WhenFull.RETIRE)
    streams.add(window(record, 0.0))
    streams.add(window(record, 100.0))
    fresh = RecordStreams(SETTINGS, WhenFull.RETIRE)
    fresh.add(window(record, 100.0))
    for after_gap, alone in zip(streams.results(), fresh.results(), strict=True):
        assert (after_gap is None) == (alone is None)
        if alone is not None:
            np.testing.assert_array_equal(after_gap.covariance.blocks, alone.covariance.blocks)


def test_whole_record_in_bounded_memory(record):
    whole, joined = WholeRecord(SETTINGS), RecordStreams(SETTINGS, WhenFull.JOIN)
    streams = RecordStreams(SETTINGS, WhenFull.RETIRE)
    for start_s in range(0, 121, 30):
        part = window(record, start_s)
        streams.add(part)
        joined.add(part)
        found = identify_bands(streams.results(), part.channels, SETTINGS, lambda hz: None)
        whole.add(part, found, singular_value_spectrum(part), DataQuality())
    result = whole.identify()
    alone = identify_samples(record, replace(SETTINGS, window_s=180.0))
    assert result.end_ns - result.start_ns == 180_000_000_000
    assert len(result.modes) == len(alone.modes) == 4
    for ours, plain in zip(result.modes, alone.modes, strict=True):
        assert abs(ours.frequency_hz - plain.frequency_hz) < plain.frequency_std_hz
    for band in joined.results():
        assert band is None or len(band.covariance.blocks) <= 64


@pytest.mark.parametrize(('starts_s', 'n_gaps'), [((0, 30, 60, 90), 0), ((0, 10, 100), 1)])
def test_blocks_of_the_window_serve_the_whole_record(record, starts_s, n_gaps):
    settings = replace(SETTINGS, window_s=80.0)
    newest = RecordStreams(settings, WhenFull.RETIRE)
    alone, sharing = (RecordStreams(settings, WhenFull.JOIN) for _ in range(2))
    for start_s in starts_s:
        part = window(record, start_s, 80.0)
        newest.add(part)
        alone.add(part)
        sharing.add(part, newest)
    assert sharing.follows[0]
    for ours, plain in zip(sharing.results(), alone.results(), strict=True):
        assert (ours is None) == (plain is None)
        if ours is None:
            continue
        assert ours.covariance.n_samples == plain.covariance.n_samples
        # Only in the block that begins at a gap are products weighted in another length; elsewhere
        # sums in single precision differ by a few roundings, as the processor orders them.
        blocks = plain.covariance.blocks
        rounding = np.finfo(np.float32).eps * np.abs(blocks).max()
        difference = np.abs(ours.covariance.blocks - blocks).max(axis=(1, 2, 3))
        assert np.count_nonzero(difference > 8.0 * rounding) <= n_gaps, difference / rounding
        np.testing.assert_allclose(ours.scale, plain.scale, rtol=1e-6)


def test_windows_that_are_out_of_step_are_summed_for_themselves(record):
    newest = RecordStreams(SETTINGS, WhenFull.RETIRE)
    newest.add(window(record, 0.0))
    alone, late = (RecordStreams(SETTINGS, WhenFull.JOIN) for _ in range(2))
    for start_s in (30.0, 60.0):
        newest.add(window(record, start_s))
        alone.add(window(record, start_s))
        late.add(window(record, start_s), newest)
    np.testing.assert_array_equal(_in_channels(late), _in_channels(alone))


def test_a_window_that_only_the_newest_streams_saw_costs_the_whole_record_little(record):
    settings = replace(SETTINGS, window_s=80.0)
    newest = RecordStreams(settings, WhenFull.RETIRE)
    alone, sharing = (RecordStreams(settings, WhenFull.JOIN) for _ in range(2))
    for start_s in (0.0, 20.0, 40.0, 60.0, 80.0, 100.0):
        part = window(record, start_s, 80.0)
        newest.add(part)
        alone.add(part)
        if start_s != 40.0:
            sharing.add(part, newest)
    assert sharing.follows[0] and not sharing.follows[-1]
    for ours, plain in zip(sharing.results(), alone.results(), strict=True):
        if ours is None or plain is None:  # the lowest band has a dozen samples
            continue
        # The memory of filters of 87 taps, each at four times the rate of the next, and a block.
        lost = plain.covariance.n_samples - ours.covariance.n_samples
        assert lost <= 87 / 4 * 4 / 3 + plain.covariance.n_samples / 30
        if ours.band.high_hz > 3.0:  # below, nothing resonates
            np.testing.assert_allclose(ours.scale, plain.scale, rtol=0.05)


def test_a_shared_decimation_makes_what_each_band_would_make():
    rows = np.random.default_rng(14).standard_normal((6000, 3))
    chunks = np.split(rows, [1500, 1501, 4000])
    bands = plan_bands(64.0, 1e9, IdentificationSettings())
    assert [len(band.factors) for band in bands] == [0, 1, 2, 3, 4]
    shared, led, alone = (Decimation() for _ in range(3))
    for chunk in chunks:
        shared.take(chunk)
        alone.take(chunk)
        for band in bands[:3]:
            shared.by(band.factors)
        led.take(chunk, shared)
        for band in bands:
            np.testing.assert_array_equal(led.by(band.factors), alone.by(band.factors))
    assert set(led.stages) == {band.factors for band in bands[3:]}
    # Rows that a stage did not see make it start anew.
    alone.take(chunks[0])
    alone.by((4,))
    alone.take(chunks[1])
    alone.take(chunks[2])
    fresh = Decimation()
    fresh.take(chunks[2])
    np.testing.assert_array_equal(alone.by((4,)), fresh.by((4,)))


def test_whole_record_goes_on_after_a_gap(record):
    streams = RecordStreams(SETTINGS, WhenFull.JOIN)
    streams.add(window(record, 0.0))
    before = streams.results()[0].covariance.n_samples
    streams.add(window(record, 100.0))
    after = streams.results()[0].covariance
    assert after.n_samples > 1.9 * before
    # Across the gap there is no product: the covariance is the mean of both sides.
    sides = []
    for start_s in (0.0, 100.0):
        side = RecordStreams(SETTINGS, WhenFull.JOIN)
        side.add(window(record, start_s))
        sides.append(_in_channels(side))
    expected = (sides[0] + sides[1]) / 2.0
    np.testing.assert_allclose(_in_channels(streams), expected, atol=0.01 * np.abs(expected).max())


def _in_channels(streams):
    """Return the covariances in units of the channels."""
    band = streams.results()[0]
    return band.mean * np.outer(band.scale, band.scale)
