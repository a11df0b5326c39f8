"""What the steps between stamps tell of rate and gaps, coarse stamps and lost samples included."""

import numpy as np
import pytest

from modal_recordings.contents.stamp_steps import stamp_steps
from modal_recordings.open_recording import open_recording

N_ROWS = 12_000


def steps_of(rate_hz, tick_s, rounding=np.rint, kept=None):
    time_s = np.arange(N_ROWS) / rate_hz
    if kept is not None:
        time_s = time_s[kept]
    return np.diff(np.rint(rounding(np.round(time_s / tick_s, 9)) * tick_s * 1e9).astype(np.int64))


@pytest.mark.parametrize('rounding', [np.rint, np.floor])
@pytest.mark.parametrize(
    ('rate_hz', 'tick_s'),
    [(200, 0.01), (200, 0.1), (1600, 1e-3), (800, 1e-3), (700, 1e-3), (640, 1e-3), (512, 1e-3)],
)
def test_the_rate_of_stamps_coarser_than_samples_is_that_of_the_samples(rate_hz, tick_s, rounding):
    told = stamp_steps(steps_of(rate_hz, tick_s, rounding))
    assert told.rate_hz == pytest.approx(rate_hz, rel=2e-3)
    assert not told.is_gap.any()


@pytest.mark.parametrize(('rate_hz', 'tick_s'), [(200, 0.01), (800, 1e-3), (200, 1e-3)])
def test_a_gap_in_coarse_stamps_is_a_gap_and_not_in_the_rate(rate_hz, tick_s):
    kept = np.setdiff1d(np.arange(N_ROWS), np.arange(5000, 5400))
    told = stamp_steps(steps_of(rate_hz, tick_s, kept=kept))
    assert told.rate_hz == pytest.approx(rate_hz, rel=2e-3)
    assert np.count_nonzero(told.is_gap) == 1
    assert abs(told.n_lost.max() - 400) <= 2


@pytest.mark.parametrize('share', [0.0001, 0.02, 0.05, 0.1, 0.2, 0.4])
def test_samples_lost_at_random_are_gaps_and_no_coarse_stamps(share):
    for seed in range(5):
        kept = np.flatnonzero(np.random.default_rng(seed).random(N_ROWS) >= share)
        told = stamp_steps(steps_of(200.0, 1e-3, kept=kept))
        assert not told.is_coarse
        assert told.rate_hz == pytest.approx(200.0, rel=1e-9)
        assert told.n_lost.sum() == kept[-1] - kept[0] + 1 - len(kept)


def test_a_sample_that_comes_twice_is_a_duplicate():
    steps = steps_of(200.0, 1e-3)
    told = stamp_steps(np.insert(steps, 100, 0))
    assert not told.is_coarse
    assert told.rate_hz == pytest.approx(200.0)


def coarse_file(tmp_path, decimals):
    path = tmp_path / 'coarse.csv'
    time_s = np.arange(N_ROWS) / 200.0
    np.savetxt(
        path,
        np.column_stack([time_s, np.sin(time_s)]),
        fmt=[f'%.{decimals}f', '%.6f'],
        delimiter=',',
        header='time [s],a [m/s^2]',
        comments='',
    )
    return path


def test_a_recording_of_coarse_stamps_is_summarised_with_its_rate(tmp_path):
    (topic,) = open_recording(coarse_file(tmp_path, 2)).info().topics
    assert topic.measured_rate_hz == pytest.approx(200.0, rel=2e-3)
    assert topic.n_gaps == topic.n_duplicates == 0


def test_a_stated_rate_gives_rows_of_coarse_times_their_place(tmp_path):
    recording = open_recording(coarse_file(tmp_path, 1), sample_rate_hz=200.0)
    assert {block.sample_rate_hz for block in recording.measurements()} == {200.0}
