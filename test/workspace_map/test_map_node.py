"""The map's node over real Fast DDS: joint states in, modes and limits of a cut out.

Nothing here measures time: every wait ends with what is waited for, or fails after a minute.
"""

import json
import threading
import time

import numpy as np
import pytest
import yaml

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = pytest.mark.node

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
import rclpy  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402

from benchmarks.workspace_map.hidden_arms import hidden_arm, known_arm, ROBOT  # noqa: E402
from machining.cut_settings import CutSettings  # noqa: E402
from machining.stability import limits_of_modes  # noqa: E402
from machining.task import axes_of, cut_of, speeds_of  # noqa: E402
from modal_core.errors import MapError  # noqa: E402
from modal_core.nodes.ros_messages import LATCHED  # noqa: E402
from oma_msgs.msg import PredictedModes, StabilityLimit  # noqa: E402
from structural_model import load_layout  # noqa: E402
from workspace_map import save_map, tool_modes, WorkspaceMap  # noqa: E402
from workspace_map.live import MotionModes  # noqa: E402
from workspace_map.node.map_node import MapNode  # noqa: E402

PATIENCE_S = 60.0
CUT = {
    'n_teeth': 2, 'diameter_mm': 12.0, 'tangential_n_mm2': 800.0, 'radial_n_mm2': 250.0,
    'min_speed_rpm': 4000.0, 'max_speed_rpm': 12000.0, 'n_speeds': 5, 'n_samples': 10,
}  # fmt: skip


@pytest.fixture(scope='module')
def known():
    """Return the map of an arm that was measured at one pose, twice."""
    arm = known_arm()
    near = hidden_arm(101).measured(arm.model.pose('P1'))
    return WorkspaceMap(arm, 60.0, (near,) * 2)


@pytest.fixture(scope='module')
def files(known, tmp_path_factory):
    folder = tmp_path_factory.mktemp('map')
    save_map(folder / 'map.json', known, load_layout(ROBOT))
    (folder / 'cut.yaml').write_text(yaml.safe_dump(CUT))
    return folder


class Cell:
    """The node on a thread, and a peer that is the bridge and whoever listens."""

    def __init__(self, context, files, **parameters):
        values = {'map': str(files / 'map.json'), **parameters}
        overrides = [Parameter(name, value=value) for name, value in values.items()]
        self.node = MapNode(context=context, parameter_overrides=overrides)
        self.peer = rclpy.create_node('peer', context=context)
        self.joints = self.peer.create_publisher(JointState, 'joint_states', 1)
        self.modes, self.limits, self.health = [], [], []
        for kind, topic, found, profile in (
            (PredictedModes, 'modal_map/predicted_modes', self.modes, LATCHED),
            (StabilityLimit, 'modal_map/stability_limit', self.limits, LATCHED),
            (DiagnosticArray, '/diagnostics', self.health, 10),
        ):
            self.peer.create_subscription(kind, topic, found.append, profile)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.peer)
        self.running = True
        self.thread = threading.Thread(target=self._spin, daemon=True)
        self.thread.start()

    def _spin(self):
        while self.running:
            self.executor.spin_once(timeout_sec=0.05)

    def stand(self, q, names, until):
        """Tell where the arm stands until a test is met."""
        deadline = time.monotonic() + PATIENCE_S
        while not until():
            assert time.monotonic() < deadline, 'waited for a minute'
            message = JointState(name=list(names), position=[float(angle) for angle in q])
            message.header.stamp.sec = 7
            self.joints.publish(message)
            time.sleep(0.02)

    def close(self):
        self.running = False
        self.thread.join(10.0)
        self.node.destroy_node()
        self.peer.destroy_node()


@pytest.fixture
def cell(ros_context, files):
    made = Cell(ros_context, files, cut=str(files / 'cut.yaml'))
    yield made
    made.close()


def last_known(found):
    return found and found[-1].known


def test_modes_follow_the_arm_and_keep_their_ids(cell, known):
    model = known.arm.model
    p1, names = model.pose('P1'), model.joint_names
    cell.stand(p1, names, lambda: last_known(cell.modes))
    near = p1 + np.deg2rad([3.0, -2.0, 2.0, 0.0, 1.0, 0.0])
    # In another order, and beside a joint that is none of the arm's.
    order = [*reversed(range(len(names)))]
    cell.stand(
        [0.3, *near[order]],
        ['track', *(names[at] for at in order)],
        lambda: np.allclose(cell.modes[-1].joint_positions, near, atol=1e-9),
    )
    first, there = cell.modes[0], cell.modes[-1]
    assert list(there.joint_names) == list(names)
    assert there.header.stamp.sec == 7
    expected = known.predict(near)
    assert [mode.frequency_hz for mode in there.modes] == pytest.approx(expected.frequency_hz)
    assert [m.frequency_std_hz for m in there.modes] == pytest.approx(expected.frequency_std_hz)
    assert [m.damping_ratio for m in there.modes] == pytest.approx(expected.damping_ratio)
    shape = np.array(there.tool_shape).reshape(-1, 3)
    assert np.array(there.modal_mass_kg) == pytest.approx(1.0 / np.sum(shape**2, axis=1))
    assert all(np.max(mode.shape_real) == pytest.approx(1.0) for mode in there.modes)
    assert list(there.channel_names) == [channel.name for channel in known.arm.channels]
    # By another way than the node's: shapes at the sensors pair the modes of both poses.
    before, after = (np.array([m.shape_real for m in each.modes]) for each in (first, there))
    norms = np.linalg.norm(before, axis=1)[:, None] * np.linalg.norm(after, axis=1)
    alike = np.abs(before @ after.T) / norms
    ids = [[mode.id for mode in each.modes] for each in (first, there)]
    assert [ids[1][at] for at in np.argmax(alike, axis=1)] == ids[0]
    assert len(set(ids[0])) == len(ids[0]) and min(ids[0]) >= 1


def test_the_limit_of_a_cut_is_that_of_the_pose(cell, known):
    model = known.arm.model
    p1 = model.pose('P1')
    cell.stand(p1, model.joint_names, lambda: last_known(cell.limits))
    found = cell.limits[-1]
    settings = CutSettings.from_mapping(CUT)
    tool = tool_modes(known.predict(p1)).turned(axes_of(settings, found.feed_deg))
    expected = limits_of_modes(tool, cut_of(settings), speeds_of(settings))
    assert list(found.spindle_speed_rpm) == pytest.approx(expected.speed_rpm)
    assert list(found.limit_m) == pytest.approx(expected.depth_m)
    assert list(found.joint_positions) == pytest.approx(p1)
    deepest = settings.max_depth_mm * 1e-3
    safe = np.minimum(found.safe_depth_m, deepest)
    assert (safe <= np.minimum(found.limit_m, deepest) * 1.5).all() and (safe > 0.0).all()
    assert found.proposed_depth_m <= deepest and found.risk == settings.risk


def test_where_the_map_does_not_know_it_says_so(cell, known):
    model = known.arm.model
    names = model.joint_names
    cell.stand(model.pose('P1'), names, lambda: last_known(cell.limits))
    cell.stand(
        model.pose('P3'), names, lambda: not (cell.modes[-1].known or cell.limits[-1].known)
    )
    for said in (cell.modes[-1], cell.limits[-1]):
        assert 'too far from every measured pose' in said.reason
    assert not cell.modes[-1].modes and not cell.limits[-1].limit_m
    with pytest.raises(MapError, match='too far'):
        MotionModes(known).at(model.pose('P3'))

    def told():
        texts = [status.message for array in cell.health for status in array.status]
        return any(text.startswith('POSE_UNKNOWN') for text in texts)

    cell.stand(model.pose('P3'), names, told)
    cell.stand(np.full(6, 9.0), names, lambda: 'outside the axis range' in cell.modes[-1].reason)


def test_joint_states_of_another_arm_are_none(cell, known):
    model, health = known.arm.model, cell.health

    def silent():
        texts = [status.message for array in health for status in array.status]
        return any(text.startswith('NO_JOINT_STATES') for text in texts)

    cell.stand(model.pose('P1'), [f'other_{at}' for at in range(6)], silent)
    broken = [*model.pose('P1')[:5], float('nan')]
    count = len(health)
    cell.stand(broken, model.joint_names, lambda: len(health) > count + 1)
    assert not cell.modes


def test_without_a_map_the_node_is_idle_and_healthy(ros_context, files):
    made = Cell(ros_context, files, map='')
    try:
        cell_says = made.health
        made.stand([], [], lambda: cell_says)
        assert cell_says[0].status[0].message == 'OK: no map is named'
        assert not made.modes
    finally:
        made.close()


def test_a_map_of_another_arm_is_refused(ros_context, files, tmp_path):
    content = json.loads((files / 'map.json').read_text())
    other = tmp_path / 'other.json'
    other.write_text(json.dumps(content | {'robot': 'another'}))
    with pytest.raises(MapError, match='a map of another robot'):
        Cell(ros_context, files, map=str(other))
