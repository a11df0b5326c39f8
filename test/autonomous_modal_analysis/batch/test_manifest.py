"""The manifest of a batch: nothing that it names is lost, nothing half-written is believed."""

from dataclasses import replace
import json

import pytest

from autonomous_modal_analysis.batch.manifest import NAME, open_manifest, TABLE
from autonomous_modal_analysis.batch.row import Row
from modal_core.errors import BatchError

ROW = Row('/a/b.mcap', 'b', 'asked', 'ama 1', 'hash', n_modes=3, remarks=('one', 'two'))


def _written(folder, *rows):
    with open_manifest(folder, resume=False) as manifest:
        for row in rows:
            manifest.add(row)
        manifest.write_table()
    return folder / NAME


def test_rows_come_back_and_the_newest_of_a_recording_counts(tmp_path):
    _written(tmp_path, ROW, replace(ROW, recording='/c', error='no'), replace(ROW, n_modes=4))
    with open_manifest(tmp_path, resume=True) as manifest:
        assert manifest.rows['/a/b.mcap'] == replace(ROW, n_modes=4)
        assert manifest.rows['/c'].error == 'no'
    assert len((tmp_path / TABLE).read_text().splitlines()) == 3


@pytest.mark.parametrize('n_lost', [1, 20])
def test_a_line_that_was_being_written_is_dropped_and_done_again(tmp_path, n_lost):
    file = _written(tmp_path, ROW, replace(ROW, recording='/c'))
    file.write_bytes(file.read_bytes()[:-n_lost])
    with open_manifest(tmp_path, resume=True) as manifest:
        assert list(manifest.rows) == ['/a/b.mcap']
        manifest.add(replace(ROW, recording='/d'))
    with open_manifest(tmp_path, resume=True) as manifest:
        assert list(manifest.rows) == ['/a/b.mcap', '/d']


@pytest.mark.parametrize(
    'line',
    [
        '[]',
        'null',
        '{"recording": 1}',
        '\x00' * 40,
        json.dumps({**ROW.values(), 'n_modes': 'x'}),
        json.dumps({**ROW.values(), 'folder': 7}),
        json.dumps({**ROW.values(), 'more': 1}),
        '[' * 100_000,
    ],
)
def test_another_file_is_no_manifest(tmp_path, line):
    (tmp_path / NAME).write_text(line + '\n')
    with (
        pytest.raises(BatchError, match='not the manifest of a batch'),
        open_manifest(tmp_path, resume=True),
    ):
        pass
    assert (tmp_path / NAME).read_text() == line + '\n'


def test_two_batches_do_not_write_one_manifest(tmp_path):
    with (
        open_manifest(tmp_path, resume=False),
        pytest.raises(BatchError, match='another batch'),
        open_manifest(tmp_path, resume=True),
    ):
        pass


def test_a_row_holds_only_for_the_same_file_asked_the_same():
    assert ROW.holds(ROW)
    for other in (replace(ROW, sha256='x'), replace(ROW, asked='x')):
        assert not ROW.holds(other)
    assert not replace(ROW, error='no').holds(ROW)
    assert not replace(ROW, sha256='').holds(replace(ROW, sha256=''))
