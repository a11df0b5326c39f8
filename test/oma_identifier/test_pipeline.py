"""Measurements in, tracked modes out."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.errors import IdentificationError
from modal_core.measurements import SampleBlock
from modal_core.quality import DataQuality
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.result import NO_MODE
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import spectrum
from oma_identifier.spectra.spectrum import singular_value_spectrum

RATE_HZ = 64.0
TRUTH = (4.0, 9.0, 9.4, 21.0)


def blocks(samples, size=64, start_ns=1_000_000_000_000):
    for first in range(0, len(samples.acceleration), size):
        yield SampleBlock(
            source='acceleration_block',
            stamp_ns=start_ns + round(first / RATE_HZ * 1e9),
            first_index=first,
            sample_rate_hz=RATE_HZ,
            channel_names=samples.channel_names,
            acceleration=samples.acceleration[first : first + size].astype(np.float32),
        )


def run(pipeline, samples):
    results = []
    for block in blocks(samples):
        pipeline.add(block)
        results += [pipeline.identify(window) for window in pipeline.windows()]
    return results + [pipeline.identify(window) for window in pipeline.finish()]


@pytest.fixture
def record(structure):
    known = structure(TRUTH, (0.02, 0.015, 0.02, 0.03))
    return known.simulate(np.random.default_rng(31), 240.0, RATE_HZ)


def test_windows_carry_the_same_ids_and_the_whole_record_has_them_too(record):
    pipeline = IdentificationPipeline(
        IdentificationSettings(window_s=60.0, hop_s=20.0, refine=False)
    )
    results = run(pipeline, record)
    assert len(results) >= 10
    ids = {
        hz: [m.id for result in results for m in result.modes if abs(m.frequency_hz - hz) < 0.2]
        for hz in (9.0, 9.4)
    }
    for found in ids.values():
        assert len(found) >= 0.8 * len(results)
        assert len(set(found)) == 1
    assert ids[9.0][0] != ids[9.4][0]
    whole = pipeline.whole()
    np.testing.assert_allclose(whole.modes.frequency_hz, TRUTH, rtol=0.01)
    near = {round(mode.frequency_hz, 0): mode.id for mode in whole.modes}
    assert near[21.0] == next(m.id for m in results[0].modes if m.frequency_hz > 20.0)
    assert 'channels_changed' not in whole.quality.flags
    assert whole.start_ns == results[0].start_ns
    assert whole.end_ns == results[-1].end_ns


def test_the_spectrum_of_the_whole_needs_no_more_than_every_sample_once(record, monkeypatch):
    settings = IdentificationSettings(window_s=60.0, hop_s=30.0, refine=False)
    made = []

    def counted(samples, *arguments):
        made.append((samples.start_ns, singular_value_spectrum(samples, *arguments)))
        return made[-1][1]

    monkeypatch.setattr(spectrum, 'singular_value_spectrum', counted)
    every = IdentificationPipeline(settings)
    results = run(every, record)
    assert len(made) == len(results) == 7
    starts = [start_ns for start_ns, _ in made]
    made.clear()
    some = IdentificationPipeline(settings, only_whole=True)
    run(some, record)
    # Windows 0, 2, 4 and 6 hold all samples.
    assert [start_ns for start_ns, _ in made] == starts[::2]
    one, other = every.whole().spectrum, some.whole().spectrum
    np.testing.assert_array_equal(one.frequency_hz, other.frequency_hz)
    # Means over 240 s, of 7 windows and of 4: a line of either scatters by more.
    apart = np.log(other.singular_value[:, 0] / one.singular_value[:, 0])
    assert np.abs(np.mean(apart)) < 0.03
    assert np.std(apart) < 0.2


def test_noise_gives_no_mode_and_a_reason(record):
    rng = np.random.default_rng(32)
    noise = replace(record, acceleration=rng.standard_normal((8000, 6)))
    results = run(IdentificationPipeline(), noise)
    for result in results:
        assert len(result.modes) == 0
        assert not result.quality.identifiable
        assert NO_MODE in result.quality.reason


def test_a_window_that_is_marked_bad_publishes_nothing(record):
    pipeline = IdentificationPipeline()
    for block in blocks(record):
        pipeline.add(block)
    window = next(iter(pipeline.windows()))
    bad = replace(window, quality=DataQuality(identifiable=False, reason='clipping'))
    result = pipeline.identify(bad)
    assert len(result.modes) == len(result.poles) == 0
    assert result.quality.reason == 'clipping'


def test_nothing_seen_is_one_clear_error():
    with pytest.raises(IdentificationError, match='nothing to identify'):
        IdentificationPipeline().whole()


@pytest.mark.parametrize(
    'method', ['ssi_data', pytest.param('plscf', marks=pytest.mark.slow), 'efdd', 'fdd']
)
def test_every_method_runs_window_by_window_and_on_the_whole(record, method):
    settings = IdentificationSettings(method=method, window_s=120.0, hop_s=60.0)
    pipeline = IdentificationPipeline(settings)
    results = run(pipeline, record)
    assert all(result.modes.method == method for result in results)
    whole = pipeline.whole()
    assert whole.modes.method == method
    assert whole.end_ns - whole.start_ns == results[-1].end_ns - results[0].start_ns
    # Plain peaks cannot part a pair within its half-power width.
    wanted = (4.0, 21.0) if 'fdd' in method else TRUTH
    for hz in wanted:
        assert np.min(np.abs(whole.modes.frequency_hz / hz - 1.0)) < 0.01, whole.modes.frequency_hz
        assert any(m.id for m in whole.modes if abs(m.frequency_hz / hz - 1.0) < 0.01)


def test_a_method_that_keeps_samples_says_when_there_are_too_many(record, monkeypatch):
    monkeypatch.setattr('oma_identifier.record.whole_record.MOST_BYTES_ALONE', 100_000)
    pipeline = IdentificationPipeline(IdentificationSettings(method='fdd'))
    run(pipeline, record)
    with pytest.raises(IdentificationError, match='fdd cannot identify this record as one'):
        pipeline.whole()
