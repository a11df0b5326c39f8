"""Many recordings at once: real files, real worker processes, and workers that are killed."""

import csv
from dataclasses import replace
import json
import os
from pathlib import Path
import signal
import subprocess
import time

import numpy as np
import pytest
from scipy.signal import lfilter

from autonomous_modal_analysis.batch.job import identify_job, Outcome
from autonomous_modal_analysis.batch.run import BatchRequest
from autonomous_modal_analysis.console.option_groups import Identifier, Reading
from autonomous_modal_analysis.identified.keeping import Keeping
from modal_core.errors import SettingsError
from modal_recordings.universal.universal_shapes import read_shapes
from oma_identifier.settings import IdentificationSettings
from test.autonomous_modal_analysis.conftest import AMA

pytest.importorskip('distributed', reason='ama batch needs distributed')
RATE_HZ = 100.0
READING = ('--sample-rate-hz', RATE_HZ)


def _frequency_hz(number):
    return 8.0 + 0.5 * number


def _record(path, number, n_samples=20_000):
    rng = np.random.default_rng(400 + number)
    pole = np.exp(2 * np.pi * _frequency_hz(number) * (-0.01 + 1j) / RATE_HZ)
    motion = lfilter([1], [1, -2 * pole.real, abs(pole) ** 2], rng.normal(size=n_samples))
    data = np.outer(motion, [1, 0.4]) + 0.1 * rng.normal(size=(n_samples, 2))
    np.save(path, data)
    return path


@pytest.fixture(scope='module')
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp('recordings')
    return [_record(folder / f'r{number}.npy', number) for number in range(4)]


def _rows(out):
    return {
        Path(row['recording']).name: row for row in csv.DictReader((out / 'manifest.csv').open())
    }


def _written_ns(out, name):
    return (out / name / 'modes.json').stat().st_mtime_ns


def _found_hz(out, name):
    return json.loads((out / name / 'modes.json').read_text())['modes'][0]['frequency_hz']


@pytest.mark.slow
def test_every_recording_has_its_folder_and_what_fails_is_a_row(ama, recordings, tmp_path):
    broken, twin = tmp_path / 'broken.npy', tmp_path / 'twin'
    broken.write_text('no array')
    twin.mkdir()
    other = _record(twin / 'r1.npy', 9)
    out = tmp_path / 'out'
    given = [*recordings, broken, tmp_path / 'missing.npy', other]
    run = ama('batch', *given, *READING, '--out', out, '--history', tmp_path / 'h.db', '--json')
    assert run.returncode == 1, run.stderr
    assert 'Traceback' not in run.stderr
    # Times of arrays begin at nothing, and a history is of the calendar.
    rows = json.loads(run.stdout)['recordings']
    assert [Path(row['recording']) for row in rows] == given
    assert all('when it was made' in row['error'] for row in rows[:4])
    run = ama('batch', *given, *READING, '--out', out)
    assert run.returncode == 2 and '--resume' in run.stderr
    run = ama('batch', *given, *READING, '--out', out, '--resume')
    assert run.returncode == 1, run.stderr
    assert '5 of 7 recordings identified' in run.stdout
    assert 'broken.npy' in run.stderr and 'missing.npy' in run.stderr
    for number in (0, 2, 3):
        assert abs(_found_hz(out, f'r{number}') / _frequency_hz(number) - 1) < 0.01
    named_alike = {row['folder']: row for row in rows if 'r1' in row['folder']}
    assert len(named_alike) == 2
    found = sorted(_found_hz(out, folder) for folder in named_alike)
    np.testing.assert_allclose(found, [_frequency_hz(1), _frequency_hz(9)], rtol=0.01)


@pytest.mark.slow
def test_workers_that_are_killed_lose_nothing(recordings, tmp_path):
    # Long enough that workers die at work.
    given = [_record(tmp_path / f'long{number}.npy', number, 60_000) for number in range(6)]
    out = tmp_path / 'out'
    command = [AMA, 'batch', *given, '--sample-rate-hz', '100', '--out', out]
    run = subprocess.Popen(
        [str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    manifest = out / 'manifest.jsonl'
    killed = []
    for n_done in (1, 3):
        _wait(lambda n=n_done: manifest.is_file() and manifest.read_text().count('\n') >= n, run)
        workers = [each for each in _workers(run.pid) if each not in killed]
        os.kill(workers[0], signal.SIGKILL)
        killed.append(workers[0])
    output, said = run.communicate(timeout=180)
    assert run.returncode == 0, said
    assert '6 of 6 recordings identified' in output
    for number in range(6):
        assert abs(_found_hz(out, f'long{number}') / _frequency_hz(number) - 1) < 0.01
    assert manifest.read_text().count('\n') == 6


@pytest.mark.slow
@pytest.mark.parametrize('delay_s', [0.0, 0.3, 1.0, 3.0])
def test_ctrl_c_while_workers_start_or_work_leaves_no_traceback(tmp_path, delay_s):
    given = [_record(tmp_path / f'long{number}.npy', number, 60_000) for number in range(6)]
    command = [AMA, 'batch', *given, '--sample-rate-hz', '100', '--out', tmp_path / 'out']
    run = subprocess.Popen(
        [str(word) for word in command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    _wait(lambda: _workers(run.pid), run)
    time.sleep(delay_s)
    # As a terminal does: to every process of the command.
    os.killpg(run.pid, signal.SIGINT)
    said, _ = run.communicate(timeout=120)
    assert run.returncode == 130, said
    assert 'Traceback' not in said and 'Exception' not in said, said


@pytest.mark.slow
def test_a_batch_that_is_killed_goes_on_where_it_was(ama, recordings, tmp_path):
    out = tmp_path / 'out'
    command = [AMA, 'batch', *recordings, '--sample-rate-hz', '100', '--out', out]
    run = subprocess.Popen([str(word) for word in command], stderr=subprocess.DEVNULL)
    manifest = out / 'manifest.jsonl'
    _wait(lambda: manifest.is_file() and b'\n' in manifest.read_bytes(), run)
    workers = _workers(run.pid)
    run.kill()
    run.wait()
    kept = [json.loads(line) for line in manifest.read_text().splitlines()]
    times = {
        row['folder']: (out / row['folder'] / 'modes.json').stat().st_mtime_ns for row in kept
    }
    # Nobody works on for a batch that is gone.
    deadline = time.monotonic() + 30.0
    while any(Path(f'/proc/{pid}').exists() for pid in workers):
        assert time.monotonic() < deadline, 'workers outlived their batch'
        time.sleep(0.1)
    again = ama('batch', *recordings, *READING, '--out', out, '--resume')
    assert again.returncode == 0, again.stderr
    for folder, time_ns in times.items():
        assert _written_ns(out, folder) == time_ns
    assert len(_rows(out)) == 4


@pytest.mark.slow
def test_a_recording_is_done_again_when_it_or_what_is_asked_changed(recordings, tmp_path):
    job = BatchRequest((recordings[0],), tmp_path, Reading(sample_rate_hz=RATE_HZ)).jobs({})[0]
    first = identify_job(job)
    assert first.is_new and not first.row.error and first.row.n_modes
    job = replace(job, done=first.row)
    assert identify_job(job) == Outcome(first.row, is_new=False)
    settings = IdentificationSettings(max_order=40)
    assert identify_job(replace(job, identifier=Identifier(settings=settings))).is_new
    assert identify_job(replace(job, recording=recordings[1])).is_new
    (job.folder / 'modes.json').unlink()
    assert identify_job(job).is_new


@pytest.mark.slow
def test_a_scheduler_that_is_not_there_is_one_line(ama, recordings, tmp_path):
    for address in ('tcp://127.0.0.1:9', 'nonsense://x', ''):
        run = ama(
            'batch', recordings[0], '--out', tmp_path / 'o', '--scheduler', address, '--resume'
        )
        assert run.returncode == 2, run.stderr
        (line,) = run.stderr.strip().splitlines()
        assert line.startswith('error: ')


def test_modes_are_written_for_other_programs_beside_the_results(tmp_path):
    request = BatchRequest(
        recordings=(_record(tmp_path / 'a.npy', 1, 4000),),
        out=tmp_path / 'out',
        reading=Reading(sample_rate_hz=RATE_HZ),
        endings=('.uff', '.csv'),
    )
    (job,) = request.jobs({})
    assert identify_job(job).row.error == ''
    modes = read_shapes(job.folder / 'modes.uff')
    assert [mode.frequency_hz for mode in modes] == pytest.approx([_frequency_hz(1)], rel=0.01)
    # An earlier batch without them has not done what is asked now.
    (bare,) = replace(request, endings=()).jobs({})
    assert bare.asked != job.asked


@pytest.mark.parametrize(
    'asked',
    [{'recordings': ()}, {'n_workers': 0}, {'keeping': '--at'}, {'endings': ('.xls',)}],
    ids=lambda each: str(each),
)
def test_what_cannot_be_meant_is_refused(asked):

    if 'keeping' in asked:
        asked = {'keeping': Keeping(at='2026-01-01')}
    with pytest.raises(SettingsError):
        BatchRequest(**{'recordings': (Path('a'),), 'out': Path('o'), **asked})


def _workers(pid):
    """Return the processes that work for a batch: its children that run the workers."""
    found = []
    for stat in Path('/proc').glob('[0-9]*/stat'):
        try:
            fields = stat.read_text().rpartition(')')[2].split()
            words = stat.with_name('cmdline').read_bytes()
        except OSError:
            continue
        if int(fields[1]) == pid and b'spawn_main' in words:
            found.append(int(stat.parent.name))
    return found


def _wait(condition, run):
    deadline = time.monotonic() + 120.0
    while not condition():
        assert run.poll() is None, run.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
