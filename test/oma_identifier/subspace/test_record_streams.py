"""A sliding window against the plain identification of the same samples."""

import numpy as np
import pytest

from modal_core.samples import Samples
from oma_identifier.covariance.bands import plan_bands
from oma_identifier.covariance.condition import Decimation
from oma_identifier.covariance.output_covariance import (
    CovarianceAccumulator,
    lagged_products,
    WhenFull,
)
from oma_identifier.identify import identify_samples
from oma_identifier.identify_bands import identify_bands
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra.harmonics import line_at
from oma_identifier.subspace.record_streams import RecordStreams

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
    streams = RecordStreams(SETTINGS)
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
    streams = RecordStreams(SETTINGS)
    streams.add(window(record, 0.0))
    streams.add(window(record, 100.0))
    fresh = RecordStreams(SETTINGS)
    fresh.add(window(record, 100.0))
    for after_gap, alone in zip(streams.results(), fresh.results(), strict=True):
        assert (after_gap is None) == (alone is None)
        if alone is not None:
            np.testing.assert_array_equal(after_gap.covariance.blocks, alone.covariance.blocks)


def test_a_shared_decimation_makes_what_each_band_would_make():
    rows = np.random.default_rng(14).standard_normal((6000, 3))
    chunks = np.split(rows, [1500, 1501, 4000])
    bands = plan_bands(64.0, 1e9, IdentificationSettings(min_frequency_hz=0.064))
    assert [len(band.factors) for band in bands] == [0, 1, 2, 3, 4]
    shared, alone = Decimation(), Decimation()
    for chunk in chunks:
        shared.take(chunk)
        alone.take(chunk)
        for band in bands:
            shared.by(band.factors)
        for band in reversed(bands):
            np.testing.assert_array_equal(shared.by(band.factors), alone.by(band.factors))
    # Rows that a stage did not see make it start anew.
    alone.take(chunks[0])
    alone.by((4,))
    alone.take(chunks[1])
    alone.take(chunks[2])
    fresh = Decimation()
    fresh.take(chunks[2])
    np.testing.assert_array_equal(alone.by((4,)), fresh.by((4,)))
