"""A campaign at a live cell: real bridge, emulated controller, and a person at the bridge."""

from contextlib import contextmanager, ExitStack
import os
from pathlib import Path
import socket
import subprocess
import sys
import time

import pytest
import yaml

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from rclpy.node import Node
from sensor_msgs.msg import Imu, JointState

from autonomous_modal_analysis.live.cell import cell_commands
from autonomous_modal_analysis.live.operator_node import OperatorNode
from autonomous_modal_analysis.live.processes import NodeProcesses
from autonomous_modal_analysis.live.spinning_node import own_domain, ros_context, spinning
from modal_core.nodes.ros_messages import LATCHED
from modal_recordings import open_recording
from oma_msgs.msg import BridgeState

pytestmark = [pytest.mark.node, pytest.mark.slow]
AMA = Path(sys.executable).with_name('ama')
PATIENCE_S = 120.0
DURATION_S = 4.0


def cell(robot='irb6660_205_190'):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    return cell_commands(
        without=('excitation_planner', 'oma_identifier'),
        parameters={
            'abb_emulator': {
                'robot': robot, 'start_pose': 'P1', 'sensors_file': 'sensors_light',
                'sensor_port': port, 'guidance.comm_timeout_s': 5.0,
            },
            'robot_bridge': {
                'robot': robot, 'port': port, 'dry_run': False, 'link_timeout_s': 5.0,
                'most_missed_cycles': 1200, 'heartbeat_timeout_s': 5.0,
            },
        },
    )  # fmt: skip


class Person:
    """Releases and starts what lies at the bridge, when it is a plan not seen before."""

    def __init__(self, operator, check):
        self.operator, self.check, self.seen = operator, check, []

    def offered(self):
        """Return the hash of a new plan that the bridge has in hand."""
        plan, state = self.operator.plan, self.operator.state
        new = plan is not None and plan.plan_hash not in self.seen
        return plan.plan_hash if new and state and state.plan_hash == plan.plan_hash else ''

    def wait(self, what, value):
        return self.operator.wait_for(what, value, PATIENCE_S, self.check)

    def is_in(self, state):
        return self.operator.state is not None and self.operator.state.state == state


@contextmanager
def neighbour(context):
    """Another cell of the domain: a bridge that never moves, joints, a sensor."""
    node = Node('robot_bridge', namespace='other', context=context)
    states = node.create_publisher(BridgeState, '~/state', LATCHED)
    states.publish(BridgeState(state=BridgeState.ABORTED, plan_hash='another'))
    joints = node.create_publisher(JointState, 'joint_states', 10)
    sensor = node.create_publisher(Imu, 'imu/elsewhere', 10)
    node.create_timer(0.02, lambda: (joints.publish(JointState()), sensor.publish(Imu())))
    with spinning(node):
        yield


@pytest.mark.parametrize('namespace', ['', 'hall/cell_1'])
def test_every_motion_waits_for_its_own_release(tmp_path, namespace):
    environment = own_domain()
    out = tmp_path / 'campaign'
    command = [
        AMA, 'campaign', '--live', '--out', out, '--sensors', 'sensors_light', '--pose-deg', 'P1',
        '--levels', '1,0.5', '--duration-s', DURATION_S, '--namespace', namespace,
    ]  # fmt: skip
    prefix = f'/{namespace}'.rstrip('/')
    with ExitStack() as stack:
        nodes = stack.enter_context(
            NodeProcesses(
                cell(), environment=environment, log_folder=tmp_path / 'log', namespace=namespace
            )
        )
        context = stack.enter_context(ros_context(environment))
        stack.enter_context(neighbour(context))
        operator = stack.enter_context(
            spinning(OperatorNode(context=context, namespace=namespace))
        )
        stack.callback(operator.close)
        campaign = subprocess.Popen(
            [str(part) for part in command],
            env={**os.environ, **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        stack.callback(campaign.kill)
        person = Person(operator, nodes.check)
        for number in range(2):
            offered = person.wait('plan', person.offered)
            person.seen.append(offered)
            time.sleep(1.0)
            assert not person.is_in(BridgeState.RUNNING), 'nobody has released this'
            assert number or not list(out.glob('*.mcap'))
            operator.run(offered, operator.state.controller, PATIENCE_S, nodes.check)
            person.wait('motion', lambda: person.is_in(BridgeState.RUNNING))
            person.wait('end of the motion', lambda: person.is_in(BridgeState.HOLDING))
        said, _ = campaign.communicate(timeout=PATIENCE_S)
    assert campaign.returncode == 0, said
    assert f'ros2 service call {prefix}/robot_bridge/arm ' in said
    for hash_ in person.seen:
        assert f'plan_hash: {hash_}' in said
    entries = yaml.safe_load((out / 'campaign.yaml').read_text())['recordings']
    assert [entry['plan_hash'] for entry in entries] == person.seen
    for entry in entries:
        recording = open_recording(out / entry['file'])
        info = recording.info()
        carried = {each.name for each in recording.attachments() if not each.problem}
        assert carried == {'robot.urdf', 'model.yaml', 'sensors.yaml', 'software.txt'}
        assert not info.damage
        sensors = {f'{prefix}/imu/{name}' for name in ('frame', 'elbow', 'forearm', 'spindle')}
        usable = {topic.name for topic in info.topics if topic.usable}
        assert usable == {*sensors, f'{prefix}/joint_states'}
        assert info.duration_s >= DURATION_S
    again = subprocess.run(
        [str(part) for part in command], env={**os.environ, **environment},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert again.returncode == 0, again.stderr
    assert again.stderr.count(': kept') == 2


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['--live', '--namespace', 'cell 1'], '--namespace: not a ROS namespace'),
        (['--namespace', 'cell_1'], 'add --live'),
    ],
)
def test_a_namespace_that_cannot_be_is_refused_at_once(tmp_path, arguments, words):
    run = subprocess.run(
        [str(AMA), 'campaign', '--out', str(tmp_path / 'c'), '--pose-deg', 'P1', *arguments],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 2
    assert words in ' '.join(run.stderr.split())
    assert 'Traceback' not in run.stderr


def test_without_a_cell_it_says_what_is_missing(tmp_path):
    environment = own_domain()
    run = subprocess.run(
        [
            str(AMA), 'campaign', '--live', '--out', str(tmp_path / 'c'), '--pose-deg', 'P1',
            '--levels', '1', '--duration-s', '4',
        ],
        env={**os.environ, **environment}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 2
    assert 'joint states and accelerations in ROS domain' in run.stderr
    assert environment['ROS_DOMAIN_ID'] in run.stderr
    assert 'Traceback' not in run.stderr
