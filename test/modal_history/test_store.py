"""What is kept is there again, whatever happens meanwhile."""

from dataclasses import replace
import os
from pathlib import Path
import resource
import signal
import sqlite3
import subprocess
import sys
import time

import numpy as np
import pytest

from autonomous_modal_analysis import history
from modal_core.errors import HistoryError, SettingsError
from modal_core.mode import ModeSet
from modal_core.numbers.indicators import mac
from modal_core.quality import DataQuality
from modal_history.pruning import prune
from modal_history.reader import HistoryReader
from modal_history.selection import Selection
from modal_history.store import HistoryWriter
from test.support.kept_results import FREQUENCIES_HZ, MINUTE_NS, ROBOT, START_NS, structure, window

ROOT = Path(__file__).resolve().parents[2]
ALL = Selection('arm')


def kept(path, asked=ALL):
    with HistoryReader(path) as reader:
        return list(reader.windows(asked))


def numbers(path):
    return [found.index for _, found in kept(path)]


@pytest.fixture
def filled(tmp_path):
    rng = np.random.default_rng(1)
    windows = [window(number, rng) for number in range(20)]
    with HistoryWriter(tmp_path / 'arm.history') as writer:
        for each in windows:
            writer.add(ROBOT, [each])
    return tmp_path / 'arm.history', windows


def test_what_was_kept_is_there_again(filled):
    path, windows = filled
    found = kept(path)
    assert len(found) == len(windows)
    for (circumstances, back), given in zip(found, windows, strict=True):
        assert circumstances == ROBOT
        same = ('index', 'start_ns', 'end_ns', 'temperature_c', 'load_kg')
        assert all(getattr(back, name) == getattr(given, name) for name in same)
        assert back.quality == given.quality
        assert back.pose.joint_names == given.pose.joint_names
        assert np.array_equal(back.pose.position, given.pose.position)
        for mode, own in zip(back.modes, given.modes, strict=True):
            assert mode.frequency_hz == own.frequency_hz and mode.mpd == own.mpd
            assert mode.frequency_std_hz == own.frequency_std_hz
            # Three digits of a shape, four per cent of a deviation.
            assert np.abs(mode.shape - own.shape).max() < 1e-3
            assert mac(mode.shape, own.shape).item() > 1.0 - 1e-6
            ratio = mode.shape_std.real / own.shape_std.real
            assert np.abs(ratio - 1.0).max() < 0.04


def test_what_is_not_known_stays_unknown(tmp_path):
    rng = np.random.default_rng(2)
    given = window(0, rng, pose=None, temperature_c=np.nan, load_kg=np.nan)
    bare = [
        replace(mode, frequency_std_hz=np.nan, shape_std=None, harmonic=mode.id == 4)
        for mode in given.modes
    ]
    deaf = replace(
        window(1, rng),
        modes=ModeSet((), ('s0.x',)),
        quality=DataQuality(identifiable=False, reason='too short'),
    )
    with HistoryWriter(tmp_path / 'h') as writer:
        writer.add(ROBOT, [replace(given, modes=replace(given.modes, modes=tuple(bare))), deaf])
    (_, back), (_, nothing) = kept(tmp_path / 'h')
    assert back.pose is None and np.isnan(back.temperature_c) and np.isnan(back.load_kg)
    assert all(np.isnan(mode.frequency_std_hz) for mode in back.modes)
    assert all(mode.shape_std is None for mode in back.modes)
    assert [mode.id for mode in back.modes] == [1, 2, 3, 0]
    assert [mode.harmonic for mode in back.modes] == [False, False, False, True]
    assert len(nothing.modes) == 0 and nothing.quality.reason == 'too short'


def test_the_same_results_are_kept_once(filled):
    path, windows = filled
    with HistoryWriter(path) as writer:
        assert writer.add(ROBOT, windows).n_new == 0
        assert writer.add(replace(ROBOT, settings='{"window_s": 30}'), windows[:3]).n_new == 3
    assert len(kept(path)) == 23


def test_a_program_killed_at_any_time_loses_nothing_it_has_said(tmp_path):
    """Seed 7: six programs, each killed with SIGKILL after a random time."""
    rng, path, said = np.random.default_rng(7), tmp_path / 'arm.history', []
    for run in range(6):
        program = subprocess.Popen(
            [sys.executable, '-m', 'test.support.write_history', path, str(1000 * run), '999'],
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        said.append(int(program.stdout.readline()))
        time.sleep(rng.uniform(0.0, 0.4))
        program.send_signal(signal.SIGKILL)
        said += [int(line) for line in program.stdout.read().split('\n')[:-1]]
        program.wait()
        program.stdout.close()
    found = kept(path)
    there = [each.index for _, each in found]
    assert set(said) <= set(there), 'seed 7'
    # And nothing in part: of the last window of each there may be all, or nothing.
    assert len(there) <= len(said) + 6 and len(set(there)) == len(there)
    assert all(len(each.modes) == len(FREQUENCIES_HZ) for _, each in found)
    assert {mode.id for _, each in found for mode in each.modes} == {1, 2, 3, 4}
    with HistoryWriter(path) as writer:
        writer.file.check()


def test_a_reader_takes_back_what_a_killed_program_left_half_written(filled):
    """Its journal says how; nobody has written since."""
    path, windows = filled
    half = (
        'import os, sqlite3, sys\n'
        'rows = sqlite3.connect(sys.argv[1], isolation_level=None)\n'
        'rows.execute("PRAGMA cache_size = 1")\n'
        'rows.execute("BEGIN IMMEDIATE")\n'
        'rows.execute("UPDATE mode SET frequency_hz = 1.0")\n'
        'rows.execute("CREATE TABLE large AS SELECT randomblob(1000000)")\n'
        'os._exit(1)\n'
    )
    subprocess.run([sys.executable, '-c', half, path], check=False)
    assert path.with_name('arm.history-journal').stat().st_size > 0
    assert numbers(path) == [each.index for each in windows]
    assert min(mode.frequency_hz for _, each in kept(path) for mode in each.modes) > 1.0


def test_two_programs_write_the_same_history(tmp_path):
    path = tmp_path / 'arm.history'
    programs = [
        subprocess.Popen(
            [sys.executable, '-m', 'test.support.write_history', path, str(first), '25'],
            stdout=subprocess.DEVNULL,
            cwd=ROOT,
        )
        for first in (0, 1000)
    ]
    assert [program.wait() for program in programs] == [0, 0]
    assert sorted(numbers(path)) == [*range(25), *range(1000, 1025)]
    assert {mode.id for _, each in kept(path) for mode in each.modes} == {1, 2, 3, 4}


def test_ids_last_over_runs_although_each_counts_its_own(tmp_path):
    """Frequencies of runs differ by 0.3 %; the second run names its modes the other way round."""
    rng, path = np.random.default_rng(3), tmp_path / 'arm.history'
    with HistoryWriter(path) as writer:
        for number in range(10):
            writer.add(ROBOT, [window(number, rng)])
    other = replace(ROBOT, recording='june.mcap', recording_hash='ab')
    with HistoryWriter(path) as writer:
        for number in range(10):
            moved = tuple(1.003 * value for value in FREQUENCIES_HZ)
            given = window(number, rng, moved, shapes=structure(), start_ns=START_NS * 2)
            turned = tuple(replace(mode, id=5 - mode.id) for mode in given.modes)
            writer.add(other, [replace(given, modes=replace(given.modes, modes=turned))])
        writer.add(
            replace(ROBOT, robot='other'), [window(0, rng, (50.0,), shapes=structure()[:, :1])]
        )
    with HistoryReader(path) as reader:
        trends = reader.trends(ALL)
        assert [trend.id for trend in trends] == [1, 2, 3, 4]
        assert [len(trend) for trend in trends] == [20] * 4
        # Of each robot ids begin anew.
        (alone,) = reader.trends(Selection('other'))
        assert alone.id == 1 and alone.frequency_hz[0] > 45.0
        with pytest.raises(SettingsError, match='more than one robot'):
            reader.robot(None)


def test_recordings_without_a_channel_in_common_are_told(tmp_path):
    rng, path = np.random.default_rng(7), tmp_path / 'arm.history'
    names = window(0, rng).modes.channel_names

    def add(number, renamed):
        given = window(number, rng)
        modes = replace(given.modes, channel_names=renamed)
        with HistoryWriter(path) as writer:
            writer.add(ROBOT, [replace(given, modes=modes)])

    other = tuple(f'tower {name}' for name in names)
    for number, renamed in enumerate((names, other)):
        add(number, renamed)
    with HistoryReader(path) as reader:
        assert reader.channel_groups(ALL) == (names, other)
    assert 'no channel in common' in history(path).trends().headline()
    add(2, (names[0], *other[1:]))
    with HistoryReader(path) as reader:
        assert len(reader.channel_groups(ALL)) == 1
    assert 'no channel in common' not in history(path).trends().headline()


def test_old_windows_go_and_the_rest_stays(filled):
    path, _ = filled
    half = START_NS + 10 * MINUTE_NS + 1
    assert prune(path, half, only_shapes=True).n_shapes == 10
    assert np.isnan(kept(path)[0][1].modes.shapes).all()
    assert kept(path)[0][1].modes.frequency_hz[0] == pytest.approx(8.3, rel=0.01)
    found = prune(path, half)
    assert found.n_windows == 10 and numbers(path) == list(range(10, 20))
    rng = np.random.default_rng(4)
    with HistoryWriter(path) as writer:
        linked = writer.add(ROBOT, [window(30, rng)]).modes[0]
    assert [mode.id for mode in linked] == [1, 2, 3, 4]


def test_pruning_gives_room_back(tmp_path):
    rng, path = np.random.default_rng(6), tmp_path / 'h'
    with HistoryWriter(path) as writer:
        writer.add(ROBOT, [window(number, rng, n_channels=60) for number in range(200)])
    found = prune(path, START_NS + 195 * MINUTE_NS)
    assert found.bytes_after < 0.5 * found.bytes_before and len(kept(path)) > 0


# -- what may be wrong with a file ---------------------------------------------------------------


def test_a_newer_version_is_refused_and_left_alone(filled):
    path, _ = filled
    rows = sqlite3.connect(path)
    rows.execute('PRAGMA user_version = 99')
    rows.close()
    before = path.read_bytes()
    for attempt in (lambda: HistoryWriter(path), lambda: HistoryReader(path)):
        with pytest.raises(HistoryError, match='newer version'):
            attempt()
    assert path.read_bytes() == before


def test_a_file_of_before_a_quantity_was_known_is_read_and_added_to(filled):
    path, _ = filled
    rows = sqlite3.connect(path)
    rows.execute('ALTER TABLE mode DROP COLUMN mac_loss_std')
    rows.close()
    assert all(np.isnan(m.mac_loss_std) for m in kept(path)[0][1].modes)
    with HistoryWriter(path) as writer:
        writer.add(ROBOT, [window(50, np.random.default_rng(8))])
    assert kept(path)[-1][1].modes.modes[0].mac_loss_std == 1e-4


@pytest.mark.parametrize('what', ['text', 'another', 'folder', 'missing', 'pipe'])
def test_what_is_no_history_is_refused_and_left_alone(tmp_path, what):
    path = tmp_path / 'it'
    if what == 'text':
        path.write_text('These are not modes.\n' * 100)
    elif what == 'another':
        rows = sqlite3.connect(path)
        rows.execute('CREATE TABLE mine (a)')
        rows.close()
    elif what == 'folder':
        path.mkdir()
    elif what == 'pipe':
        os.mkfifo(path)
    before = path.read_bytes() if path.is_file() else None
    with pytest.raises(HistoryError) as told:
        HistoryReader(path)
    assert '\n' not in str(told.value)
    if what != 'missing':
        with pytest.raises(HistoryError):
            HistoryWriter(path)
    assert before is None or path.read_bytes() == before


@pytest.mark.parametrize('seed', range(12))
def test_a_damaged_file_is_told_in_one_line(filled, seed):
    """Bytes of random places are changed, or the end is cut off."""
    path, _ = filled
    rng, data = np.random.default_rng(seed), bytearray(path.read_bytes())
    if seed % 3:
        first = int(rng.integers(0 if seed % 2 else 4096, len(data) - 3000))
        data[first : first + 3000] = rng.bytes(3000)
    else:
        del data[int(rng.integers(100, len(data) - 100)) :]
    path.write_bytes(data)
    try:
        kept(path)
        prune(path)
    except HistoryError as told:
        assert '\n' not in str(told)
        if path.exists():
            assert path.read_bytes() == data, f'seed {seed}'


def test_a_full_disk_is_told_and_loses_nothing(filled):
    path, _ = filled
    there, limit = numbers(path), path.stat().st_size + 3 * 16384
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    rng = np.random.default_rng(9)
    with HistoryWriter(path) as writer:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
        try:
            with pytest.raises(HistoryError) as told:
                for number in range(100, 1000):
                    writer.add(ROBOT, [window(number, rng)])
                    there.append(number)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
            signal.signal(signal.SIGXFSZ, ignored)
        assert '\n' not in str(told.value)
        assert numbers(path) == there
        # And when there is room again it goes on, with the ids it had.
        linked = writer.add(ROBOT, [window(2000, rng)]).modes[0]
    assert [mode.id for mode in linked] == [1, 2, 3, 4]
    assert numbers(path) == [*there, 2000]


def test_a_folder_that_may_not_be_written_to(filled):
    path, _ = filled
    with pytest.raises(HistoryError, match='cannot be opened'):
        HistoryWriter(Path('/proc/arm.history'))
    with pytest.raises(HistoryError, match='cannot be opened'):
        HistoryWriter(path.parent / 'none' / 'arm.history')
    code = (
        'import os, sys; from pathlib import Path\n'
        'from modal_history.reader import HistoryReader; from modal_history.store import *\n'
        f'path = Path({str(path)!r}); os.setuid(65534)\n'
        'print(len(HistoryReader(path).runs()))\n'
        'try:\n    HistoryWriter(path)\n'
        'except Exception as error:\n    print(error)\n'
    )
    if os.geteuid() != 0:
        pytest.skip('needs to become somebody else')
    for folder in (path.parent, *path.parent.parents):
        if folder.stat().st_uid == 0 and folder != Path('/') and folder != Path('/tmp'):
            folder.chmod(0o755)
    path.chmod(0o444)
    ended = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, cwd=ROOT, check=False
    )
    runs, refusal = ended.stdout.splitlines() or ('', ended.stderr)
    assert runs == '1' and 'cannot be written' in refusal, ended.stderr


@pytest.mark.slow
def test_a_month_of_one_result_a_minute_is_less_than_200_megabytes(tmp_path):
    """42 channels and 10 modes; a day of it, as every day takes as much."""
    rng, path, n_day = np.random.default_rng(10), tmp_path / 'day', 24 * 60
    frequencies_hz = tuple(8.0 + 6.0 * place for place in range(10))
    some = [window(number, rng, frequencies_hz, 42) for number in range(60)]
    day = [replace(some[n % 60], index=n, start_ns=START_NS + n * MINUTE_NS) for n in range(n_day)]
    with HistoryWriter(path) as writer:
        writer.add(ROBOT, day)
    assert 30 * path.stat().st_size < 200e6
