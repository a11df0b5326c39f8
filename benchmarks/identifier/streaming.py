"""One streaming step: a second of new samples in, a result of the whole window out.

`python -m benchmarks.identifier.streaming FILE N` runs with N references in a process of its
own, so that its memory is its own.
"""

from collections.abc import Iterator
import json
from pathlib import Path
import subprocess
import sys
import tempfile
import time

import numpy as np

from benchmarks.identifier.record import names
from benchmarks.table import Line
from modal_core.measurements import NANOSECONDS_PER_SECOND, SampleBlock
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings

WINDOW_S, RATE_HZ, N_CHANNELS = 60, 512, 42
START_NS = 1_700_000_000 * NANOSECONDS_PER_SECOND
SEED = 75000
WARM_UP = 5
REACH_MS = {6: 30.0, 42: 50.0}


def rows(full: bool) -> Iterator[Line]:
    """Yield the lines."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'record.f4'
        _write_record(path, WINDOW_S + WARM_UP + (200 if full else 30))
        for n_references, reach_ms in REACH_MS.items():
            yield from _lines(n_references, reach_ms, _measured(path, n_references))


def _lines(n_references: int, reach_ms: float, answer: dict[str, float]) -> Iterator[Line]:
    what = f'streaming, {WINDOW_S} s window, 42 channels, {n_references} references'
    median, most, resident = answer['median_ms'], answer['most_ms'], answer['resident_mb']
    met = median <= reach_ms
    yield Line(
        f'{what}: CPU of a 1 s step', f'{median:.0f} ms', '-', '-', f'≤ {reach_ms:g} ms', met
    )
    what_delay = f'{what}: slowest result after its last sample, CPU'
    yield Line(what_delay, f'{most / 1e3:.2f} s', '-', '-', '< 0.3 s', most < 300.0)
    met = resident < 200.0
    yield Line(f'{what}: resident memory', f'{resident:.0f} MB', '-', '-', '< 200 MB', met)


def _write_record(path: Path, seconds: int) -> None:
    from benchmarks.identifier.plant import chain_plant, simulate

    samples = simulate(
        chain_plant(N_CHANNELS), np.random.default_rng(SEED), float(seconds), float(RATE_HZ)
    )
    samples.acceleration.astype(np.float32).tofile(path)


def _measured(path: Path, n_references: int) -> dict[str, float]:
    process = subprocess.run(
        [
            sys.executable,
            '-W',
            'ignore',
            '-m',
            f'{__package__}.streaming',
            path,
            str(n_references),
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(process.stdout.splitlines()[-1])


def stream(path: Path, n_references: int) -> dict[str, float]:
    """Return what the steps after the first full window cost.

    The delay counts from the arrival of the block that fills the window, in CPU time: what an
    idle core would take.
    """
    settings = IdentificationSettings(
        window_s=WINDOW_S, hop_s=1.0, n_references=n_references, max_order=60
    )
    pipeline = IdentificationPipeline(settings)
    channels = tuple(channel.name for channel in names(N_CHANNELS))
    costs: list[float] = []
    with path.open('rb') as file:
        for second in range(path.stat().st_size // (4 * N_CHANNELS * RATE_HZ)):
            rows = np.fromfile(file, np.float32, N_CHANNELS * RATE_HZ).reshape(RATE_HZ, N_CHANNELS)
            stamp = START_NS + second * NANOSECONDS_PER_SECOND
            block = SampleBlock('/block', stamp, second * RATE_HZ, float(RATE_HZ), channels, rows)
            start = time.process_time()
            pipeline.add(block)
            results = [pipeline.identify(window) for window in pipeline.windows()]
            if results:
                costs.append(time.process_time() - start)
    kept = 1e3 * np.array(costs[WARM_UP:])
    status = Path('/proc/self/status').read_text(encoding='ascii').split('VmRSS:')[1]
    return {
        'median_ms': float(np.median(kept)),
        'most_ms': float(kept.max()),
        'resident_mb': float(status.split()[0]) / 1024.0,
    }


if __name__ == '__main__':
    print(json.dumps(stream(Path(sys.argv[1]), int(sys.argv[2]))))
