"""CPU seconds and peak memory of one case, in its own process on one BLAS thread."""

from dataclasses import dataclass, field
import json
import os
from pathlib import Path
import subprocess
import sys
import tempfile

import numpy as np

ONE_THREAD = dict.fromkeys(('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS'), '1')
TIMEOUT_S = 900


@dataclass(frozen=True)
class Cost:
    """What one case cost.

    Parameters
    ----------
    cpu_s : float [s]
        Process time of the call; imports, reading and simulation excluded.
    peak_mb : float [MB]
        Largest resident set of the process, libraries and record included.
    error : str
        Why there is no figure.
    found : mapping of str to array
        What the case found, see :class:`benchmarks.identifier.record.Found`.
    """

    cpu_s: float = float('nan')
    peak_mb: float = float('nan')
    error: str = ''
    found: dict[str, np.ndarray] = field(default_factory=dict)


def measure(case: str, record: Path) -> Cost:
    """Run one case of :mod:`benchmarks.identifier.cases` on a stored record in a subprocess."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / 'found.npz'
        command = [sys.executable, '-W', 'ignore', '-m', f'{__package__}.cases', case]
        try:
            process = subprocess.run(
                [*command, str(record), str(result)],
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
        with np.load(result) as found:
            return Cost(answer['cpu_s'], answer['peak_mb'], found=dict(found))
