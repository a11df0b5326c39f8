"""Use the installed suite as a user would; run with its Python, away from the source tree."""

from collections.abc import Iterator, Sequence
import contextlib
from importlib.metadata import version
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

BIN = Path(sys.executable).parent
NODES = ('abb_emulator', 'excitation_planner', 'oma_identifier', 'replay', 'robot_bridge')
RATE_HZ, LENGTH_S, SEED = 200.0, 120.0, 5
MODES_HZ = (11.0, 27.0)
PATIENCE_S = 60.0
# A domain of its own, so that nodes that run elsewhere are neither seen nor disturbed.
DOMAIN = {'ROS_DOMAIN_ID': '93', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}


def run(*arguments: str, expected: int = 0) -> str:
    """Run an installed program; return what it wrote."""
    started = time.monotonic()
    ended = subprocess.run(
        [BIN / arguments[0], *arguments[1:]], capture_output=True, text=True, timeout=300
    )
    said = ended.stdout + ended.stderr
    assert ended.returncode == expected, f'{arguments}: {ended.returncode}\n{said}'
    assert 'Traceback' not in said, said
    print(f'{" ".join(arguments)}: {time.monotonic() - started:.1f} s')
    return ended.stdout if expected == 0 else said


def without_ros() -> None:
    """What needs no ROS works; what needs it says in one line what to install."""
    import modal_recordings

    assert 'site-packages' in modal_recordings.__file__, modal_recordings.__file__
    assert run('ama', '--version').split()[1] == version('autonomous_modal_analysis')
    write_blocks(Path('blocks.mcap'))
    identify_blocks()
    run('ama', 'compare', 'results', 'blocks.mcap')
    run('ama', 'model', 'irb6660_205_190')
    run('ama', 'plan', 'irb6660_205_190', '--pose-deg', 'P1', '--duration-s', '10')
    campaign = ('--pose-deg', 'P1', '--levels', '1', '--duration-s', '10')
    run('ama', 'campaign', '--out', 'campaign', *campaign)
    run('ama', 'info', str(next(Path('campaign').glob('*.mcap'))))
    run('ama', 'gap', 'nowhere', '--model', 'irb6660_205_190', expected=2)
    for command in (('ama', 'up'), ('ama', 'demo'), ('ama', 'replay', 'blocks.mcap')):
        refused(*command)
    for node in NODES:
        refused(node)


def identify_blocks() -> None:
    """Find the modes of a recording of blocks."""
    assert len(json.loads(run('ama', 'info', 'blocks.mcap', '--json'))['channels']) == 2
    found = json.loads(run('ama', 'identify', 'blocks.mcap', '--out', 'results', '--json'))
    frequencies = [mode['frequency_hz'] for mode in found['modes']]
    for true in MODES_HZ:
        assert any(abs(each / true - 1.0) < 0.01 for each in frequencies), frequencies


def refused(*command: str) -> None:
    """Check that a command says in one line what to install."""
    said = run(*command, expected=2)
    assert len(said.strip().splitlines()) == 1, said
    assert 'ros-jazzy-rclpy' in said and 'oma_msgs' in said, said


def write_blocks(path: Path) -> None:
    """Record two modes, driven by noise, as AccelerationBlock messages."""
    import numpy as np
    from scipy.signal import lfilter

    from modal_core.measurements import SampleBlock
    from modal_recordings import RecordingWriter
    from modal_recordings.messages import encode

    rng = np.random.default_rng(SEED)
    n_samples = int(RATE_HZ * LENGTH_S)
    response = 0.02 * rng.normal(size=(n_samples, 2))
    for mode, frequency in enumerate(MODES_HZ):
        pole = np.exp(2j * np.pi * frequency / RATE_HZ - 0.015 * 2 * np.pi * frequency / RATE_HZ)
        motion = lfilter(
            [1.0, -1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], rng.normal(size=n_samples)
        )
        response += np.outer(motion, (1.0, 0.6 if mode == 0 else -0.8))
    with RecordingWriter(path) as writer:
        for first in range(0, n_samples, 50):
            block = SampleBlock(
                '/acceleration_block',
                round(1e9 * (1000.0 + first / RATE_HZ)),
                first,
                RATE_HZ,
                ('base.x', 'tip.x'),
                response[first : first + 50].astype(np.float32),
            )
            for message in encode(block, '/acceleration_block'):
                writer.write(
                    message.topic, message.message_type, message.log_time_ns, message.data
                )


def with_ros() -> None:
    """The whole loop, every node's executable, and both ways to play a recording."""
    os.environ.update(DOMAIN)
    run('ama', 'demo')
    run('ama', 'info', 'ama_demo/demo.mcap')
    assert json.loads(run('ama', 'identify', 'ama_demo/demo.mcap', '--json'))['modes']
    identify_blocks()
    said = run('ama', 'replay', 'blocks.mcap', '--rate', '30', '--json')
    assert json.loads(said)['windows'], said
    with running([[node, *options(node)] for node in NODES]):
        pass
    with running([['ama', 'up']], nodes=[node for node in NODES if node != 'replay']):
        pass


def options(node: str) -> Sequence[str]:
    """Return what a node must be told."""
    if node == 'replay':
        return ('--ros-args', '-p', f'recording:={Path("blocks.mcap").absolute()}')
    files = {'abb_emulator': 'emulator', 'robot_bridge': 'bridge', 'oma_identifier': 'identifier'}
    share = Path(sys.prefix, 'share', 'autonomous_modal_analysis', 'config')
    return ('--ros-args', '--params-file', f'{share / files.get(node, "planner")}.yaml')


@contextlib.contextmanager
def running(commands: Sequence[Sequence[str]], nodes: Sequence[str] = NODES) -> Iterator[None]:
    """Start programs, wait for their nodes, stop them as Ctrl-C does."""
    started = [
        subprocess.Popen(
            [BIN / command[0], *command[1:]],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        for command in commands
    ]
    try:
        missing = wait_for(set(nodes))
        yield
    finally:
        for process in started:
            process.send_signal(signal.SIGINT)
        said = [process.communicate(timeout=PATIENCE_S)[1] for process in started]
    assert not missing, f'{missing} did not come up: {said}'
    for command, process, errors in zip(commands, started, said, strict=True):
        assert process.returncode == 0, f'{command}: {process.returncode}\n{errors}'
        assert 'Traceback' not in errors, errors
        print(f'{" ".join(command)}: came up and stopped')


def wait_for(names: set[str]) -> set[str]:
    """Return which nodes have not come up in time."""
    import rclpy

    context = rclpy.Context()
    rclpy.init(context=context, signal_handler_options=rclpy.SignalHandlerOptions.NO)
    watcher = rclpy.create_node('watcher', context=context)
    deadline = time.monotonic() + PATIENCE_S
    while (missing := names - set(watcher.get_node_names())) and time.monotonic() < deadline:
        time.sleep(0.2)
    time.sleep(1.0)
    watcher.destroy_node()
    rclpy.try_shutdown(context=context)
    return missing


if __name__ == '__main__':
    {'without_ros': without_ros, 'with_ros': with_ros}[sys.argv[1]]()
