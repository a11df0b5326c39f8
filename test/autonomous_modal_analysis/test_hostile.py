"""Commands on hostile files, consoles and signals: one line, no traceback, no hang."""

import json
import math
import os
from pathlib import Path
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from autonomous_modal_analysis.read_results import read_modes
from modal_core.errors import RecordingError

AMA = (sys.executable, '-P', '-m', 'autonomous_modal_analysis')
SEED = 1309
MODE = {
    'id': 1, 'frequency_hz': 5.0, 'frequency_std_hz': 0.01, 'damping_ratio': 0.01,
    'damping_ratio_std': None, 'shape_real': [1.0, 0.5], 'shape_imag': [0.0, 0.0], 'mpc': 1.0,
    'mpd': 0.0,
}  # fmt: skip


@pytest.fixture(scope='module')
def recording(tmp_path_factory):
    """Return two channels of a mode at 5 Hz, the first with a name that steers terminals."""
    folder = tmp_path_factory.mktemp('hostile')
    path = folder / 'arm.npy'
    rng = np.random.default_rng(SEED)
    noise = np.fft.rfft(rng.normal(size=(6000, 2)), axis=0)
    f = np.fft.rfftfreq(6000, 0.01)[:, None]
    np.save(path, np.fft.irfft(noise / (25.0 - f**2 + 0.1j * 5.0 * f), axis=0))
    name = 'x\x1b]0;owned\x07\u202e±'
    Path(f'{path}.yaml').write_text(
        json.dumps({'sample_rate_hz': 100, 'unit': 'g', 'channels': ['=1+1', 'b']})
    )
    (folder / f'{name}.npy').symlink_to(path)
    Path(f'{folder / name}.npy.yaml').write_text(Path(f'{path}.yaml').read_text())
    return folder / f'{name}.npy'


def ama(*arguments, **options):
    return subprocess.run(
        [*AMA, *map(str, arguments)], capture_output=True, timeout=120, check=False, **options
    )


@pytest.mark.parametrize(
    'change',
    [
        {'frequency_hz': -5.0},
        {'frequency_hz': None},
        {'frequency_hz': 1e300},
        {'frequency_hz': math.inf},
        {'frequency_hz': '5'},
        {'frequency_std_hz': -1.0},
        {'damping_ratio': -0.01},
        {'damping_ratio': 1.5},
        {'shape_real': [1.0]},
        {'shape_real': [1.0, math.nan]},
        {'shape_real': [0.0, 0.0]},
        {'shape_real': [5e-324, 0.0]},
        {'shape_real': [1.0, 1e300]},
        {'shape_real': [[1.0, 2.0]], 'shape_imag': [[0.0, 0.0]]},
        {'id': 1e300},
        {'mpc': 2.0},
        {},
    ],
    ids=str,
)
def test_results_are_only_taken_back_as_an_identification_can_be(tmp_path, change):
    path = tmp_path / 'modes.json'
    kept = {'shape_channels': ['a', 'b'], 'settings': {}, 'modes': [{**MODE, **change}]}
    path.write_text(json.dumps(kept))
    if not change:
        assert read_modes(path).frequency_hz.tolist() == [5.0]
        return
    with pytest.raises(RecordingError, match='not the results of an identification'):
        read_modes(path)


@pytest.mark.slow
@pytest.mark.parametrize('suffix', ['.npy', '.csv', '.mcap', '.db3', '.bag', '.json', '.yaml'])
def test_nothing_of_a_file_that_a_link_leads_to_is_shown(tmp_path, suffix):
    (tmp_path / 'key').write_text('hunter2: -----BEGIN PRIVATE KEY-----\n[hunter2]\n' * 50)
    link = tmp_path / f'link{suffix}'
    link.symlink_to(tmp_path / 'key')
    np.save(tmp_path / 'x.npy', np.zeros((100, 1)))
    call = {
        '.json': ('compare', link, link),
        '.yaml': ('identify', tmp_path / 'x.npy', '--sample-rate-hz', 9, '--layout', link),
    }.get(suffix, ('info', link))
    done = ama(*call)
    assert done.returncode == 2 and done.stderr.count(b'\n') == 1
    assert not any(word in done.stderr + done.stdout for word in (b'hunter', b'BEGIN', b'-----'))


@pytest.mark.slow
@pytest.mark.parametrize('encoding', ['ascii', 'latin-1', 'cp437', 'utf-8', 'utf-16'])
def test_a_console_of_few_letters_shows_all_and_is_not_steered(recording, encoding):
    environment = {**os.environ, 'PYTHONIOENCODING': encoding}
    for call in (('info', recording), ('--help',)):
        done = ama(*call, env=environment)
        assert done.returncode == 0 and b'Traceback' not in done.stderr, done.stderr
        shown = done.stdout.decode(encoding) + done.stderr.decode(encoding)
        assert all(line.isprintable() for line in shown.split('\n'))
        assert call[0] == '--help' or r'\x1b' in shown


@pytest.mark.slow
@pytest.mark.parametrize('kind', ['closed', 'full', 'broken', 'all full', 'no language'])
def test_a_console_that_takes_nothing_ends_in_one_line_at_most(recording, kind):
    ending = {
        'closed': '>&-', 'full': '>/dev/full', 'broken': '| true',
        'all full': '>/dev/full 2>&1', 'no language': '>/dev/null',
    }[kind]  # fmt: skip
    environment = {**os.environ, 'FILE': str(recording), 'LC_ALL': 'C', 'PYTHONUTF8': '0'}
    for command in ('info "$FILE"', 'info "$FILE" --json', '--help'):
        line = f'{" ".join(AMA)} {command} {ending}'
        done = subprocess.run(
            ['bash', '-c', line], capture_output=True, timeout=60, check=False, env=environment
        )
        assert b'Traceback' not in done.stderr and b'Exception' not in done.stderr, done.stderr
        assert done.stderr.count(b'\n') <= 1
        assert kind != 'full' or done.returncode == 2 or command == '--help'


@pytest.mark.parametrize('number', [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_signal_where_python_drops_exceptions_ends_it_all_the_same(number):
    program = f"""
import signal, time, weakref
from autonomous_modal_analysis.console.signals import prepare_signals
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
prepare_signals()
class Thing: pass
thing = Thing()
last = weakref.ref(thing, lambda _: signal.raise_signal({int(number)}))
del thing
time.sleep(20)
print('went on')
"""
    run = subprocess.run(
        [sys.executable, '-c', program], capture_output=True, timeout=60, check=False
    )
    assert run.stdout == b''
    if number == signal.SIGINT:
        assert run.stderr.strip().endswith(b'KeyboardInterrupt')
    else:
        assert (run.returncode, run.stderr) == (128 + number, b'')


@pytest.mark.slow
@pytest.mark.parametrize('command', ['--help', 'info', 'identify'])
def test_a_signal_at_any_time_ends_a_command_without_a_traceback(recording, command):
    rng = random.Random(SEED)
    for delay_s in (rng.uniform(0.2, 2.0) for _ in range(12)):
        number = rng.choice([signal.SIGINT, signal.SIGTERM])
        arguments = () if command == '--help' else (str(recording),)
        process = subprocess.Popen(
            [*AMA, command, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        time.sleep(delay_s)
        process.send_signal(number)
        _, said = process.communicate(timeout=60)
        # Nor may it: only the interpreter's own beginning is beyond the suite.
        late = b'autonomous_modal_analysis' in said or b'site-packages' in said
        assert not (b'Traceback' in said and late), (
            f'seed {SEED}, {number!r} after {delay_s:.3f} s: {said}'
        )


@pytest.mark.slow
def test_folders_that_take_no_files_leave_nothing_half_written(recording, tmp_path):
    (tmp_path / 'file').write_text('here')
    for out in (tmp_path / 'file', tmp_path / 'file' / 'below', '/proc/nothing', '/dev/null'):
        done = ama('identify', recording, '--window-s', 20, '--out', out)
        assert done.returncode == 2 and b'Traceback' not in done.stderr, done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ['file']


@pytest.mark.parametrize('nested', [20_000, 900])
def test_metadata_of_brackets_is_refused(tmp_path, nested):
    (tmp_path / 'metadata.yaml').write_text('a: ' + '[' * nested + ']' * nested)
    (tmp_path / 'x.db3').write_bytes(b'SQLite format 3\x00' + bytes(1000))
    done = ama('info', tmp_path)
    assert done.returncode == 2 and done.stderr.count(b'\n') == 1
    assert b'nested too deeply' in done.stderr
