"""Cells without a number in text files: lost values, as gaps are, whatever the logger writes."""

import numpy as np
import pytest

from modal_core.errors import RecordingError
from modal_recordings.open_recording import open_recording

SEED = 987520
N_ROWS = 400
VALUES = np.round(np.random.default_rng(SEED).normal(size=(N_ROWS, 3)), 4)
WORDS = [
    '', '-', '---', 'NaN', 'nan', '-nan', 'NA', 'N/A', '#N/A', '#n/a', '<NA>', 'null', 'None',
    '-nan(ind)', 'nan(snan)', '1.#QNAN', '-1.#IND', '1.#INF', '#VALUE!', '#DIV/0!', '#NUM!', 'OL',
    'OVER', '-OVER', 'OVERLOAD', '*****', '+++++',
]  # fmt: skip


def lost_cells():
    return np.random.default_rng(SEED + 1).random(VALUES.shape) < 0.02


def put(folder, cells, separator=',', timed=True, decimal='.'):
    rows = [[f'{n / 250:.4f}'.replace('.', decimal), *row] for n, row in enumerate(cells)]
    lines = [separator.join(row if timed else row[1:]) for row in rows]
    above = 'time [s],a,b,c' if timed else 'a,b,c'
    path = folder / 'logger.csv'
    path.write_text(above.replace(',', separator) + '\n' + '\n'.join(lines) + '\n')
    return path


def cells_with(word, decimal='.'):
    text = np.array([[f'{v:.4f}'.replace('.', decimal) for v in row] for row in VALUES], object)
    text[lost_cells()] = word
    return text


def gathered(recording):
    return np.concatenate([part.acceleration for part in recording.measurements()])


@pytest.mark.parametrize('timed', [True, False])
@pytest.mark.parametrize('word', WORDS)
def test_what_says_that_there_is_no_number_is_a_lost_value(tmp_path, word, timed):
    stated = {} if timed else {'sample_rate_hz': 250.0}
    recording = open_recording(put(tmp_path, cells_with(word), timed=timed), **stated)
    assert not lost_cells().all(axis=1).any(), SEED
    assert np.array_equal(gathered(recording), np.where(lost_cells(), np.nan, VALUES), True)
    (note,) = (note for note in recording.notes if 'no numbers' in note)
    assert f'{np.sum(lost_cells()[:, 0])} of a' in note


@pytest.mark.parametrize('word', ['', '#N/A', '-nan(ind)', '-'])
def test_so_it_is_beside_decimal_commas(tmp_path, word):
    path = put(tmp_path, cells_with(word, ','), ';', decimal=',')
    recording = open_recording(path)
    assert np.array_equal(gathered(recording), np.where(lost_cells(), np.nan, VALUES), True)


@pytest.mark.parametrize('first', [0, 1, 2])
def test_the_first_row_may_lack_a_value(tmp_path, first):
    text = cells_with('nan')
    text[0] = [f'{v:.4f}' for v in VALUES[0]]
    text[0][first] = ''
    found = gathered(open_recording(put(tmp_path, text)))
    assert len(found) == N_ROWS and np.flatnonzero(np.isnan(found[0])).tolist() == [first]


def test_other_words_are_refused_by_place(tmp_path):
    text = cells_with('nan')
    text[6, 1] = 'broken'
    with pytest.raises(RecordingError, match=r"line 8, column 3: not a number.*'broken'"):
        open_recording(put(tmp_path, text))


def test_a_time_that_is_missing_is_refused_by_place(tmp_path):
    path = put(tmp_path, cells_with('nan'))
    path.write_text(path.read_text().replace('\n0.0400,', '\n,'))
    with pytest.raises(RecordingError, match='row 11: time is not finite'):
        open_recording(path)
