"""Two whole cells on one ROS domain, as `ama up` starts them: one operator moves one arm."""

from contextlib import contextmanager
import os
from pathlib import Path
import shutil
import signal
import socket
import subprocess
import sys
import time

from mcap.reader import make_reader
import numpy as np
import pytest
import yaml

from modal_core.errors import BridgeError
from modal_core.files.share import share_path
from test.support.domains import ros_domain

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = [pytest.mark.node, pytest.mark.slow, pytest.mark.timeout(600)]

ROBOT = share_path('config', 'robots', 'irb6660_205_190')
SENSORS = ('frame', 'elbow')
PATIENCE_S = 120.0
# Of a busy machine: emulated time stands still when its process waits.
CALM = {
    'robot_bridge.dry_run': 'false',
    'robot_bridge.link_timeout_s': '2.0',
    'robot_bridge.heartbeat_timeout_s': '2.0',
    'robot_bridge.most_missed_cycles': '500',
    'abb_emulator.guidance.comm_timeout_s': '2.0',
    'oma_identifier.window_s': '8.0',
    'oma_identifier.hop_s': '4.0',
}
STILL_DEG = 1e-3


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


class Cell:
    """`ama up` of an arm with sensors of its own."""

    def __init__(self, folder: Path, domain: int, name: str, seed: int, **options: str):
        self.name, self.folder, self.port = name, folder / name, free_port()
        robot = self.folder / 'robot'
        shutil.copytree(ROBOT, robot)
        sensors = [
            {'name': f'{name}_{sensor}', 'frame_id': frame, 'position_m': [0.1, 0.0, 0.2]}
            for sensor, frame in zip(SENSORS, ('link_1', 'link_3'), strict=True)
        ]
        (robot / 'sensors.yaml').write_text(yaml.safe_dump({'sensors': sensors}))
        nodes = ('robot_bridge', 'abb_emulator', 'excitation_planner')
        parameters = {
            **CALM,
            **{f'{node}.robot': str(robot) for node in nodes},
            'robot_bridge.packet_log': str(self.folder / 'egm.mcap'),
            'excitation_planner.seed': str(seed),
            'excitation_planner.duration_s': '30.0',
        }
        self.process = subprocess.Popen(
            [
                sys.executable, '-m', 'autonomous_modal_analysis', 'up',
                '--egm-port', str(self.port),
                *(f'--{key}={value}' for key, value in options.items()),
                '--log-folder', str(self.folder / 'log'),
                *(f'--parameter={key}={value}' for key, value in parameters.items()),
            ],
            env={**os.environ, 'ROS_DOMAIN_ID': str(domain)},
        )  # fmt: skip

    @property
    def controller(self) -> str:
        return f'127.0.0.1:{self.port}'

    @property
    def channels(self) -> set[str]:
        return {f'{self.name}_{sensor}.{axis}' for sensor in SENSORS for axis in 'xyz'}

    def check(self) -> None:
        assert self.process.poll() is None, f'{self.name} has ended'

    def stop(self) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(60.0) == 0, self.name

    def joints_deg(self) -> tuple[np.ndarray, np.ndarray]:
        """Return what its controller said of its axes, (n, 6) [deg], and when by its own clock.

        The times, (n,) [s], count from where its bridge gave up the motion, if it did.
        """
        from robot_bridge.egm.egm_messages import EgmRobot

        rows, given_up_s = [], None
        with (self.folder / 'egm.mcap').open('rb') as file:
            for _, channel, record in make_reader(file).iter_messages():
                if channel.topic == 'egm/robot':
                    message = EgmRobot.FromString(record.data)
                    rows.append((message.header.tm * 1e-3, *message.feedBack.joints.joints))
                elif channel.topic == 'robot_bridge/events' and b'ABORTED' in record.data:
                    given_up_s = given_up_s or rows[-1][0]
        found = np.array(rows)
        return found[:, 0] - (given_up_s or 0.0), found[:, 1:]


def moved_deg(joints_deg: np.ndarray) -> float:
    """Return the largest range of an axis."""
    return float(np.ptp(joints_deg, axis=0).max())


class Seen:
    """What a watcher of one cell remembers."""

    def __init__(self, operator):
        from sensor_msgs.msg import JointState

        from oma_msgs.msg import BridgeState

        self.operator, self.states, self.joints = operator, [], []
        operator.create_subscription(BridgeState, 'robot_bridge/state', self.states.append, 100)
        operator.create_subscription(JointState, 'joint_states', self.joints.append, 1000)

    def moved_deg(self, first: int = 0) -> float:
        return moved_deg(np.degrees([message.position for message in self.joints[first:]]))

    def has(self, state: int, controller: str) -> bool:
        return any(
            item.state == state and item.controller == controller for item in self.states[-20:]
        )


@pytest.fixture
def domain() -> int:
    return ros_domain(3)


@pytest.fixture
def context(domain):
    import rclpy

    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    yield context
    rclpy.try_shutdown(context=context)


@contextmanager
def person(context, namespace=''):
    from autonomous_modal_analysis.live.operator_node import OperatorNode
    from autonomous_modal_analysis.live.spinning_node import spinning

    node = OperatorNode(context=context, namespace=namespace)
    seen = Seen(node)
    with spinning(node):
        try:
            yield seen
        finally:
            node.close()


@pytest.fixture
def cells(tmp_path, domain):
    started = []

    def start(name, seed, **options):
        started.append(Cell(tmp_path, domain, name, seed, **options))
        return started[-1]

    yield start
    for cell in started:
        cell.stop()


def until(what, condition, *alive):
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        for cell in alive:
            cell.check()
        assert time.monotonic() < deadline, what
        time.sleep(0.05)


def ready(seen, cell):
    """Wait until the arm stands at its start and its plan is in hand; return the plan."""
    operator = seen.operator
    until(
        f'{cell.name} ready',
        lambda: (
            operator.plan is not None
            and operator.state is not None
            and operator.state.controller == cell.controller
            and operator.state.controller_state == 'running'
            and operator.state.plan_hash == operator.plan.plan_hash
        ),
        cell,
    )
    return operator.plan


def release(seen, cell, controller=None):
    seen.operator.run(
        seen.operator.plan.plan_hash, controller or cell.controller, PATIENCE_S, cell.check
    )


def test_cells_in_namespaces_work_side_by_side(cells, context):
    from oma_msgs.msg import BridgeState

    one, two = cells('cell_1', 1, namespace='cell_1'), cells('cell_2', 2, namespace='cell_2')
    with person(context, 'cell_1') as first, person(context, 'cell_2') as second:
        plans = [ready(first, one), ready(second, two)]
        assert plans[0].plan_hash != plans[1].plan_hash
        far_deg = [np.degrees(max(plan.position_range)) for plan in plans]
        # A release for the other arm moves neither.
        with pytest.raises(BridgeError, match='controller'):
            release(first, one, two.controller)
        # One operator moves one arm.
        release(first, one)
        until('the first arm moves', lambda: first.operator.state.progress > 0.4, one, two)
        assert first.moved_deg() > 0.3 * far_deg[0]
        assert second.moved_deg() < STILL_DEG
        assert second.operator.state.state == BridgeState.IDLE
        # The other operator the other; letting go stops one's own only.
        release(second, two)
        until('the second arm moves', lambda: second.operator.state.progress > 0.2, one, two)
        first.operator.close()
        until('the first arm stops', lambda: first.has(BridgeState.ABORTED, one.controller))
        assert second.operator.state.state == BridgeState.RUNNING
        until('end of the plan', lambda: second.has(BridgeState.HOLDING, two.controller), one, two)
        assert second.moved_deg() > 0.5 * far_deg[1]
        # Each identifier hears its own sensors, and both have.
        for seen, cell in ((first, one), (second, two)):
            until('windows', lambda seen=seen: len(seen.operator.windows) >= 2, one, two)
            for window in seen.operator.windows:
                assert set(window.channel_names) <= cell.channels, cell.name
            assert set(seen.operator.windows[-1].channel_names) == cell.channels, cell.name


def test_a_second_cell_of_the_same_names_moves_no_arm_and_stops_the_first(cells, context):
    from oma_msgs.msg import BridgeState

    one = cells('cell_1', 1)
    with person(context) as seen:
        ready(seen, one)
        release(seen, one)
        until('the arm moves', lambda: seen.operator.state.progress > 0.05, one)
        two = cells('cell_2', 2)
        until('the first aborts', lambda: seen.has(BridgeState.ABORTED, one.controller), one, two)
        until(
            'the second refuses',
            lambda: any(
                state.controller == two.controller and 'another node' in state.reason
                for state in seen.states
            ),
            one,
            two,
        )
        time.sleep(1.0)
        for cell in (one, two):
            with pytest.raises(BridgeError):
                release(seen, cell)
        time.sleep(4.0)
    one.stop()
    two.stop()
    time_s, joints_deg = one.joints_deg()
    assert moved_deg(joints_deg) > 10 * STILL_DEG
    # It slows down within the stop ramp; the controller's own loop settles a sweep in two seconds.
    at_rest = time_s > 2.0
    assert at_rest.sum() > 100
    assert moved_deg(joints_deg[at_rest]) < STILL_DEG
    assert moved_deg(two.joints_deg()[1]) < STILL_DEG
