"""A hundred recordings in one batch, a worker killed twice: every row right; work per core.

Right is what a single run of the same recording gives, to the last digit, in a row without error,
with the hash of its file.  Work is processor time of all processes, Dask's own and all imports
included, over that of one process that does the same recordings one after the other:
`python -m benchmarks.batch`.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
import hashlib
import json
import os
from pathlib import Path
import resource
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.table import HEADER, Line

N_RECORDINGS, DURATION_S = 100, 20.0
N_LONG, LONG_S = 8, 300.0
"""Short recordings for the rows, long ones for the work: starts of processes then count little."""
RATE_HZ, N_CHANNELS = 100.0, 4
DAMPING_RATIO = 0.02
FIRST_SEED = 884_000
KILLED_AFTER = (20, 60)
"""Rows in the manifest when a worker is killed."""
LOOKS_S, LONGEST_S = 0.05, 3600.0
ENVIRONMENT = dict.fromkeys(('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS'), '1')
SINGLE = """
import sys
from pathlib import Path
from autonomous_modal_analysis.batch.job import BatchJob, identify_job
from autonomous_modal_analysis.identified.keeping import Keeping
from autonomous_modal_analysis.console.option_groups import Identifier, Reading
rate_hz, out, *paths = sys.argv[1:]
for path in map(Path, paths):
    reading = Reading(sample_rate_hz=float(rate_hz))
    job = BatchJob(path, Path(out) / path.stem, reading, Identifier(), Keeping())
    outcome = identify_job(job)
    assert not outcome.row.error, outcome.row.error
"""


def truth_hz(number: int) -> tuple[float, float]:
    """Return the natural frequencies of a recording, which no other has."""
    return 6.0 + 0.05 * number, 17.0 + 0.1 * number


def record(folder: Path, number: int, duration_s: float = DURATION_S) -> Path:
    """Write a recording of two modes under white noise."""
    generator = np.random.default_rng([FIRST_SEED, number])
    n_samples = round(duration_s * RATE_HZ)
    data: NDArray[np.float64] = np.zeros((n_samples, N_CHANNELS))
    for hz in truth_hz(number):
        pole = np.exp(2 * np.pi * hz * (-DAMPING_RATIO + 1j) / RATE_HZ)
        force = generator.standard_normal(n_samples)
        motion = lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], force)
        data += np.outer(motion / motion.std(), generator.standard_normal(N_CHANNELS))
    data += 0.05 * generator.standard_normal(data.shape)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f'cell_{number:03d}.npy'
    np.save(path, data)
    return path


def rows(n_recordings: int = N_RECORDINGS, n_long: int = N_LONG) -> Iterator[Line]:
    """Yield the lines of the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        yield from _killed(folder, n_recordings)
        yield from _work(folder, n_long)


def _killed(folder: Path, n_recordings: int) -> Iterator[Line]:
    paths = [record(folder / 'short', number) for number in range(n_recordings)]
    single(folder / 'single', paths)
    killed = batch(folder / 'batch', paths, KILLED_AFTER)
    right = sum(is_right(path, folder / 'batch', folder / 'single') for path in paths)
    yield Line(
        f'{n_recordings} recordings in one run, a worker killed {killed} times: rows right',
        str(right), reach=str(n_recordings), met=right == n_recordings,
    )  # fmt: skip
    found = sum(
        _finds(folder / 'batch' / path.stem, truth_hz(number)) for number, path in enumerate(paths)
    )
    yield Line('recordings with both true modes within 2 %', f'{found} of {n_recordings}')


def _work(folder: Path, n_long: int) -> Iterator[Line]:
    paths = [record(folder / 'long', number, LONG_S) for number in range(n_long)]
    single_s = _processor_s(lambda: single(folder / 'long_single', paths))
    batch_s = _processor_s(lambda: batch(folder / 'long_batch', paths))
    share = single_s / batch_s
    yield Line(
        f'throughput per core, {n_long} recordings of {LONG_S:.0f} s, to that of one process',
        f'{share:.2f}', reach='≥ 0.9', met=share >= 0.9,
    )  # fmt: skip


def single(out: Path, paths: list[Path]) -> None:
    """Identify recordings one after the other in one process of its own."""
    command = [sys.executable, '-c', SINGLE, str(RATE_HZ), str(out), *map(str, paths)]
    subprocess.run(command, check=True, env={**os.environ, **ENVIRONMENT})


def batch(out: Path, paths: list[Path], killed_after: tuple[int, ...] = ()) -> int:
    """Run a batch to its end; kill a worker at so many rows each, and return how many died.

    Raises
    ------
    RuntimeError
        It did not end well.
    """
    program = 'from autonomous_modal_analysis.cli import main; main()'
    words = ('batch', *map(str, paths), '--sample-rate-hz', str(RATE_HZ), '--out', str(out))
    run = subprocess.Popen(
        [sys.executable, '-c', program, *words], env={**os.environ, **ENVIRONMENT},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    manifest, dead = out / 'manifest.jsonl', set[int]()
    for n_rows in killed_after:
        while not manifest.is_file() or manifest.read_text().count('\n') < n_rows:
            if run.poll() is not None:
                raise RuntimeError(f'the batch ended before {n_rows} rows')
            time.sleep(LOOKS_S)
        worker = next(pid for pid in workers_of(run.pid) if pid not in dead)
        os.kill(worker, signal.SIGKILL)
        dead.add(worker)
    said, _ = run.communicate(timeout=LONGEST_S)
    if run.returncode != 0:
        raise RuntimeError(f'the batch ended with {run.returncode}: {said}')
    return len(dead)


def workers_of(pid: int) -> list[int]:
    """Return the processes that identify, of a batch."""
    found = []
    for stat in Path('/proc').glob('[0-9]*/stat'):
        with suppress(OSError):
            parent = int(stat.read_text().rpartition(')')[2].split()[1])
            if parent == pid and b'spawn_main' in stat.with_name('cmdline').read_bytes():
                found.append(int(stat.parent.name))
    return found


def is_right(path: Path, out: Path, alone: Path) -> bool:
    """Return whether a recording's row and results are those of a single run."""
    lines = (out / 'manifest.jsonl').read_text().splitlines()
    own = [row for row in map(json.loads, lines) if row['recording'] == str(path.resolve())]
    if len(own) != 1 or own[0]['error']:
        return False
    found, expected = (_modes(folder / path.stem) for folder in (out, alone))
    hashed = own[0]['sha256'] == hashlib.sha256(path.read_bytes()).hexdigest()
    return hashed and found == expected and own[0]['n_modes'] == len(found)


def _modes(folder: Path) -> list[object]:
    return list(json.loads((folder / 'modes.json').read_text())['modes'])


def _finds(folder: Path, wanted_hz: tuple[float, float]) -> bool:
    modes = json.loads((folder / 'modes.json').read_text())['modes']
    return all(any(abs(m['frequency_hz'] / hz - 1.0) < 0.02 for m in modes) for hz in wanted_hz)


def _processor_s(work: Callable[[], object]) -> float:
    """Return the processor time of the processes that work starts and waits for."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    work()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


if __name__ == '__main__':
    print(HEADER)
    for line in rows():
        print(line.markdown(), flush=True)
