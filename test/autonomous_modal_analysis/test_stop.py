"""A command that is stopped ends its nodes with it, and leaves no half-written file."""

import os
from pathlib import Path
import signal
import socket
import subprocess
import sys
import time

import pytest

from modal_core.files.share import share_path
from test.support.domains import ros_domain

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = pytest.mark.node
AMA = Path(sys.executable).with_name('ama')
OTHERS = ('excitation_planner', 'oma_identifier', 'abb_emulator')
PATIENCE_S = 90.0


def start(folder):
    """Start `ama up` with the bridge alone; return it, its node's process id and its port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    config, work = folder / 'config', folder / 'work'
    config.mkdir()
    work.mkdir()
    text = (share_path('config') / 'bridge.yaml').read_text()
    (config / 'bridge.yaml').write_text(text.replace('port: 6510', f'port: {port}'))

    def default_interrupt():
        signal.signal(signal.SIGINT, signal.default_int_handler)

    process = subprocess.Popen(
        [
            str(AMA), 'up', '--config', str(config),
            *(word for name in OTHERS for word in ('--without', name)),
        ],
        cwd=work,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, 'ROS_DOMAIN_ID': str(ros_domain(31))},
        preexec_fn=default_interrupt,
    )  # fmt: skip
    children = Path(f'/proc/{process.pid}/task/{process.pid}/children')
    until(lambda: children.read_text().split(), 'a node')
    return process, int(children.read_text().split()[0]), port


def until(condition, what):
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.02)


def listens(port):
    """Tell whether the bridge has come as far as its EGM socket."""
    return f'0100007F:{port:04X}' in Path('/proc/net/udp').read_text().split()


def state_of(pid):
    try:
        return Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()[0]
    except FileNotFoundError:
        return 'gone'


@pytest.mark.parametrize('ready', [True, False], ids=['running', 'importing'])
@pytest.mark.parametrize('numbers', [(signal.SIGINT, signal.SIGINT), (signal.SIGTERM,)])
def test_no_node_outlives_its_command(tmp_path, numbers, ready):
    process, node, port = start(tmp_path)
    if ready:
        until(lambda: listens(port), 'the bridge listens')
    for number in numbers:
        process.send_signal(number)
        time.sleep(0.05)
    said, _ = process.communicate(timeout=PATIENCE_S)
    # A second interrupt that comes after all is done ends what is left of the process.
    assert process.returncode in ((0,) if len(numbers) == 1 else (0, -signal.SIGINT)), said
    assert 'Traceback' not in said, said
    assert state_of(node) == 'gone'
    assert list((tmp_path / 'work').rglob('*')) == []
