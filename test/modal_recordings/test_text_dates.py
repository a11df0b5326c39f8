"""Dates in text files: the order of day and month by the dates, and times that rows share."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from modal_core.errors import RecordingError
from modal_recordings.open_recording import open_recording

SEED = 987521
DAY = datetime(2026, 1, 5, 10)
PATTERNS = {
    'ISO': '%Y-%m-%d %H:%M:%S.%f',
    'day first': '%d/%m/%Y %H:%M:%S.%f',
    'month first': '%m/%d/%Y %I:%M:%S.%f %p',
    'dots': '%d.%m.%Y %H:%M:%S.%f',
    'two digits': '%d-%m-%y %H:%M:%S.%f',
    'year first, two digits': '%y/%m/%d %H:%M:%S.%f',
    'date and time apart': '%d/%m/%Y,%H:%M:%S.%f',
}


def put(folder, start, pattern, period_s=0.01, n_rows=600, lost=slice(0, 0)):
    values = np.random.default_rng(SEED).normal(size=(n_rows, 2))
    times = [start + timedelta(seconds=period_s * n) for n in range(n_rows)]
    rows = [f'{t.strftime(pattern)},{a:.4f},{b:.4f}' for t, (a, b) in zip(times, values, strict=1)]
    del rows[lost]
    names = 'time,a,b' if ',' not in pattern else 'date,time,a,b'
    path = folder / 'logger.csv'
    path.write_text('\n'.join([names, *rows]) + '\n')
    return path


def seconds_since_1970(date):
    return (date - datetime(1970, 1, 1)) / timedelta(seconds=1)


@pytest.mark.parametrize('pattern', PATTERNS)
def test_dates_that_pass_midnight_tell_day_and_month(tmp_path, pattern):
    """Else the recording would last a month, or a year."""
    start = datetime(2026, 1, 5, 23, 59, 57)
    recording = open_recording(put(tmp_path, start, PATTERNS[pattern]))
    stamps = recording.row_stamps_ns()
    assert stamps[0] * 1e-9 == pytest.approx(seconds_since_1970(start), abs=1e-6)
    assert np.ptp(stamps) * 1e-9 == pytest.approx(5.99, abs=1e-6)
    assert not any('date' in note for note in recording.notes)


@pytest.mark.parametrize('pattern', PATTERNS)
def test_a_date_that_could_be_several_is_not_used_and_said(tmp_path, pattern):
    recording = open_recording(put(tmp_path, DAY, PATTERNS[pattern]))
    stamps = recording.row_stamps_ns()
    is_told = any('which number is the day' in note for note in recording.notes)
    assert is_told == (pattern not in ('ISO', 'dots'))
    day = DAY if not is_told else datetime(1970, 1, 1, 10)
    assert stamps[0] * 1e-9 == pytest.approx(seconds_since_1970(day), abs=1e-6)
    assert recording.sample_rate_hz == pytest.approx(100.0)


@pytest.mark.parametrize('day', [datetime(2026, 5, 5, 10), datetime(2026, 1, 25, 10)])
@pytest.mark.parametrize('pattern', ['day first', 'month first'])
def test_a_date_that_can_be_one_only_is_used(tmp_path, day, pattern):
    recording = open_recording(put(tmp_path, day, PATTERNS[pattern]))
    assert recording.row_stamps_ns()[0] * 1e-9 == pytest.approx(seconds_since_1970(day))
    assert not any('date' in note for note in recording.notes)


@pytest.mark.parametrize('rate_hz', [100.0, 51.3])
def test_whole_seconds_are_counted_out(tmp_path, rate_hz):
    start = DAY + timedelta(seconds=0.4)
    path = put(tmp_path, start, '%Y-%m-%d %H:%M:%S', 1.0 / rate_hz, 4000)
    recording = open_recording(path)
    assert recording.sample_rate_hz == pytest.approx(rate_hz, rel=1e-3)
    true_s = seconds_since_1970(start) + np.arange(4000) / rate_hz
    assert np.abs(recording.row_stamps_ns() * 1e-9 - true_s).max() < 2.5 / rate_hz
    assert any('several rows share each time' in note for note in recording.notes)


def test_whole_seconds_with_a_pause_are_counted_out(tmp_path):
    rate_hz, start = 51.3, DAY + timedelta(seconds=0.4)
    path = put(tmp_path, start, '%Y-%m-%d %H:%M:%S', 1.0 / rate_hz, 4000, lost=slice(1510, 1910))
    recording = open_recording(path)
    assert recording.sample_rate_hz == pytest.approx(rate_hz, rel=1e-3)
    true_s = seconds_since_1970(start) + np.delete(np.arange(4000), slice(1510, 1910)) / rate_hz
    assert np.abs(recording.row_stamps_ns() * 1e-9 - true_s).max() < 2.5 / rate_hz
    assert any('evenly spaced, with 1 pause,' in note for note in recording.notes)


def test_whole_seconds_with_rows_lost_are_refused(tmp_path):
    path = put(tmp_path, DAY, '%Y-%m-%d %H:%M:%S', 0.01, 4000, lost=slice(1510, 1550))
    with pytest.raises(RecordingError, match='rows share times, and not evenly many do'):
        open_recording(path)
