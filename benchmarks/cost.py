"""CPU seconds and peak memory of one case, measured in its own process on one BLAS thread."""

from dataclasses import dataclass
import json
import os
from pathlib import Path
import subprocess
import sys

ONE_THREAD = dict.fromkeys(('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS'), '1')
TIMEOUT_S = 600


@dataclass(frozen=True)
class Cost:
    """What one case cost.

    Parameters
    ----------
    cpu_s : float [s]
        Process time of the call, imports and simulation excluded.
    peak_mb : float [MB]
        Largest resident set of the process.
    error : str
        Why there is no figure.
    detail : str
        What the case says about its accuracy.
    """

    cpu_s: float = float('nan')
    peak_mb: float = float('nan')
    error: str = ''
    detail: str = ''


def measure(case: str, window: Path) -> Cost:
    """Run one case of :mod:`benchmarks.cases` on a stored window in a subprocess."""
    try:
        process = subprocess.run(
            [sys.executable, '-W', 'ignore', '-m', 'benchmarks.cases', case, str(window)],
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
            env={**os.environ, **ONE_THREAD},
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Cost(error=f'> {TIMEOUT_S} s')
    if process.returncode:
        lines = process.stderr.strip().splitlines()
        return Cost(error=lines[-1] if lines else f'exit {process.returncode}')
    answer = json.loads(process.stdout.strip().splitlines()[-1])
    return Cost(answer['cpu_s'], answer['peak_mb'], detail=answer['detail'])
