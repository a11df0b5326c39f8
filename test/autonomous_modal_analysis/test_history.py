"""Results of several recordings in one history, as people and programs ask for them."""

import json

import numpy as np
import pytest
from scipy.signal import lfilter
from typer.testing import CliRunner

import autonomous_modal_analysis
from autonomous_modal_analysis.cli import app
from modal_core.errors import ModalAnalysisError
from test.support.exported_rows import rows_of
from test.support.kept_results import softened

SEED, RATE_HZ = 21, 100.0


def ama(*words):
    """Run a command in this process: here its words count, not its start."""
    return CliRunner().invoke(app, [str(word) for word in words])


def record(path, softer, seed):
    """Write two minutes of three modes under noise; their stiffness is less by a share."""
    rng = np.random.default_rng(seed)
    shapes = np.array([[1.0, 0.6, 0.3], [0.5, -1.0, 0.9], [-0.3, 0.4, 1.0]])
    response = np.zeros((12_000, 3))
    for place, frequency_hz in enumerate((4.0, 9.0, 17.0)):
        decay = 2 * np.pi * frequency_hz * np.sqrt(1.0 - softer) * (-0.015 + 1j) / RATE_HZ
        poles = np.poly(np.exp([decay, decay.conj()])).real
        force = lfilter([1.0, -1.0], poles, rng.normal(size=len(response)))
        response += np.outer(force, shapes[:, place])
    response += 0.02 * response.std() * rng.normal(size=response.shape)
    np.save(path, response)
    return path


OPTIONS = ('--sample-rate-hz', '100', '--unit', 'm/s^2', '--channels', 'a,b,c', '--json')


@pytest.fixture(scope='module')
def filled(tmp_path_factory):
    folder = tmp_path_factory.mktemp('history')
    path = folder / 'arm.history'
    for month, softer in ((4, 0.0), (5, 0.04)):
        recording = record(folder / f'month_{month}.npy', softer, SEED + month)
        at = ('--at', f'2026-0{month}-01', '--tool', 'gripper', '--temperature-c', '21.5')
        run = ama('identify', recording, *OPTIONS, '--history', path, *at)
        assert run.exit_code == 0 and 'results added' in run.stderr, run.stderr
    return path


def test_runs_are_listed(filled):
    run = ama('history', 'list', filled, '--json')
    first, second = json.loads(run.stdout)['runs']
    assert (first['recording'], second['recording']) == ('month_4.npy', 'month_5.npy')
    assert first['recording_hash'] != second['recording_hash']
    assert first['settings_hash'] == second['settings_hash'] and 'window_s' in first['settings']
    assert first['tool'] == 'gripper' and first['n_modes'] == 3
    shown = ama('history', 'list', filled)
    assert 'month_4.npy' in shown.stdout and '2026-05-01' in shown.stdout


def test_modes_keep_their_ids_and_show_what_became_softer(filled):
    """4 % less stiffness is 2 % less frequency."""
    run = ama('history', 'trends', filled, '--whole', '--json')
    trends = json.loads(run.stdout)['trends']
    assert len(trends) == 3, f'seed {SEED}: {trends}'
    for trend, frequency_hz in zip(trends, (4.0, 9.0, 17.0), strict=True):
        (before, after), stds = trend['frequency_hz'], trend['frequency_std_hz']
        assert abs(before - frequency_hz) < 4 * stds[0], f'seed {SEED}'
        assert abs(after - frequency_hz * np.sqrt(0.96)) < 4 * stds[1], f'seed {SEED}'
        assert trend['temperature_c'] == [21.5, 21.5]
    since = ama('history', 'trends', filled, '--since', '2026-04-20', '--mode', '1', '--json')
    (one,) = json.loads(since.stdout)['trends']
    assert max(one['frequency_hz']) < 4.0 and one['id'] == 1
    assert '3 modes' in ama('history', 'trends', filled).stdout


def test_a_recording_is_kept_once(filled):
    again = filled.parent / 'month_4.npy'
    run = ama('identify', again, *OPTIONS, '--history', filled, '--at', '2026-04-01',
              '--tool', 'gripper')  # fmt: skip
    assert 'all results were there already' in run.stderr


def test_a_recording_without_a_date_is_asked_for_one_before_the_work(filled):
    before = filled.read_bytes()
    run = ama('identify', filled.parent / 'month_4.npy', *OPTIONS, '--history', filled)
    assert '--at' in str(run.exception) and filled.read_bytes() == before


@pytest.mark.parametrize('kind', ['csv', 'parquet', 'mat', 'nc'])
def test_tables_hold_every_mode_with_its_shape(filled, kind):
    file = filled.parent / f'modes.{kind}'
    run = ama('history', 'export', filled, file, '--whole')
    assert run.exit_code == 0, run.stderr
    rows = rows_of(file)
    assert len(rows) == 6
    assert {row['recording'] for row in rows} == {'month_4.npy', 'month_5.npy'}
    for row in rows:
        entries = [complex(float(row[f'shape_real.{c}']), float(row[f'shape_imag.{c}']))
                   for c in 'abc']  # fmt: skip
        assert max(map(abs, entries)) == pytest.approx(1.0, abs=1e-3)
        assert float(row['frequency_std_hz']) > 0.0


def test_python_gives_data_frames(filled):
    pandas = pytest.importorskip('pandas')
    history = autonomous_modal_analysis.history(filled)
    assert 'month_4.npy' in repr(history) and len(history.to_dataframe()) == 2
    table = history.trends(whole=True).to_dataframe()
    assert isinstance(table, pandas.DataFrame) and len(table) == 6
    steps = table.groupby('id').frequency_hz.agg(lambda f: f.iloc[1] / f.iloc[0])
    assert np.allclose(steps, np.sqrt(0.96), atol=0.01)


def test_what_cannot_be_done_is_one_line(filled, tmp_path):
    attempts = (
        ('list', tmp_path / 'none'),
        ('trends', filled, '--robot', 'nobody'),
        ('trends', filled, '--since', 'yesterday'),
        ('export', filled, tmp_path / 'modes.xls'),
        ('prune', filled, '--before', '31.5.'),
        ('prune', tmp_path / 'none'),
    )
    for attempt in attempts:
        run = ama('history', *attempt)
        assert isinstance(run.exception, ModalAnalysisError), attempt
        assert '\n' not in str(run.exception)
    assert not (tmp_path / 'none').exists()


def test_pruning_says_what_went(filled, tmp_path):
    copy = tmp_path / 'copy'
    copy.write_bytes(filled.read_bytes())
    run = ama('history', 'prune', copy, '--before', '2026-04-20')
    assert run.exit_code == 0 and 'windows removed' in run.stderr
    (left,) = json.loads(ama('history', 'list', copy, '--json').stdout)['runs']
    assert left['recording'] == 'month_5.npy'


def test_alarms_are_shown_kept_and_acknowledged(tmp_path):
    path, learnt = softened(tmp_path / 'arm.history'), ('--baseline-days', '0.08')
    shown = ama('history', 'alarms', path, *learnt)
    assert '1 open alarm' in shown.output and '-1.4' in shown.output
    assert 'changes are told of mode 2' in shown.output
    (one,) = json.loads(ama('history', 'alarms', path, *learnt, '--json').stdout)['alarms']
    assert one['number'] == 1 and one['id'] == 1 and one['open'] is True
    assert abs(one['share'] + 0.015) < 3.5 * one['share_std']
    taken = ama('history', 'alarms', path, *learnt, '--acknowledge', 1)
    assert '0 open alarms' in taken.output and 'acknowledged' in taken.output
    table = autonomous_modal_analysis.history(path).alarms('arm', baseline_days=0.08)
    assert not any(alarm.is_open for alarm in table.alarms)
