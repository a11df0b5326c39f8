"""The command line as a user runs it, to hold the API against."""

from pathlib import Path
import subprocess
import sys

import pytest

from test.support.frame import FLOORS, Frame, shaken_frame


@pytest.fixture(scope='session')
def frame() -> Frame:
    return shaken_frame(seed=5)


@pytest.fixture(scope='session')
def identified(frame):
    import autonomous_modal_analysis as ama

    return ama.identify(frame.acceleration, frame.sample_rate_hz, channel_names=FLOORS)


@pytest.fixture(scope='session')
def ama_command():
    """Return a function that runs ``ama`` and gives its standard output."""

    def run(*arguments: object, cwd: Path | None = None) -> str:
        finished = subprocess.run(
            [sys.executable, '-m', 'autonomous_modal_analysis', *map(str, arguments)],
            cwd=cwd,
            capture_output=True,
            text=True,
            timeout=200,
            check=False,
        )
        assert finished.returncode == 0, finished.stderr
        return finished.stdout

    return run


@pytest.fixture
def no_window(monkeypatch):
    """Draw into memory, with matplotlib if it is there."""
    matplotlib = pytest.importorskip('matplotlib')
    matplotlib.use('Agg')
    yield
    matplotlib.pyplot.close('all')
