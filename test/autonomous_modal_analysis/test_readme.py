"""The commands of the read-me do what it says."""

from pathlib import Path
import shlex
import signal
import subprocess
import time

import numpy as np
import pytest

from test.autonomous_modal_analysis.conftest import AMA

ROOT = Path(__file__).resolve().parents[2]
pytestmark = [pytest.mark.node, pytest.mark.slow]


# Until somebody stops them: below, and in a terminal beside it (operating/test_operate_node.py).
IN_A_CELL = ('ama up', 'ama operate')


def commands() -> list[str]:
    lines = (ROOT / 'README.md').read_text().splitlines()
    return [line.strip() for line in lines if line.startswith('    ama ')]


@pytest.fixture(scope='module')
def place(finished_demo, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp('readme')
    (folder / 'ama_demo').symlink_to(finished_demo.folder)
    rng = np.random.default_rng(5)
    np.save(folder / 'tower.npy', rng.normal(size=(12000, 3)))
    return folder


def test_the_readme_shows_commands():
    assert {command.split()[1] for command in commands()} >= {
        'info',
        'identify',
        'replay',
        'plan',
        'model',
        'up',
    }


@pytest.mark.parametrize('command', [line for line in commands() if line not in IN_A_CELL])
def test_a_command_of_the_readme_succeeds(command, place):
    arguments = command.split('>')[0]
    run = subprocess.run(
        [str(AMA), *shlex.split(arguments)[1:]],
        cwd=place,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert 'Traceback' not in run.stderr
    assert 'Warning' not in run.stderr, run.stderr


def test_up_starts_the_nodes_and_stops_them_on_ctrl_c(tmp_path):
    environment_domain = {'ROS_DOMAIN_ID': '77', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    process = subprocess.Popen(
        [
            'env',
            *(f'{k}={v}' for k, v in environment_domain.items()),
            str(AMA),
            'up',
            '--log-folder',
            str(tmp_path),
        ],
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(15.0)
    assert process.poll() is None, process.stderr.read()
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 0, said
    assert 'stopping' in said
    for name in ('abb_emulator', 'robot_bridge', 'excitation_planner', 'oma_identifier'):
        log = (tmp_path / f'{name}.log').read_text()
        assert 'Traceback' not in log, f'{name}: {log}'
