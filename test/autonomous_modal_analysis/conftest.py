"""One run of the demo serves all tests that look at what it leaves."""

from dataclasses import dataclass
from pathlib import Path
import subprocess
import sys

import pytest

AMA = Path(sys.executable).with_name('ama')


@dataclass(frozen=True)
class FinishedDemo:
    folder: Path
    status: int
    output: str


def run_ama(*arguments: object, cwd: Path | None = None, timeout: float = 240.0):
    """Run the installed command line as a user would."""
    return subprocess.run(
        [str(AMA), *(str(argument) for argument in arguments)],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


@pytest.fixture(scope='session')
def ama():
    return run_ama


@pytest.fixture(scope='session')
def finished_demo(tmp_path_factory) -> FinishedDemo:
    folder = tmp_path_factory.mktemp('demo') / 'ama_demo'
    run = run_ama('demo', '--out', folder)
    return FinishedDemo(folder, run.returncode, run.stdout + run.stderr)
