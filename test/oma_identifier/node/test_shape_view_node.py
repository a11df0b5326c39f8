"""What plotters, monitors and viewers of the arm get from the identifier, over real Fast DDS."""

import time

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Float64
from visualization_msgs.msg import Marker, MarkerArray

from modal_core.layouts.shipped_layouts import shipped_layout
from modal_core.nodes.ros_messages import LATCHED
from oma_msgs.msg import ExcitationPlan
from test.oma_identifier.node.test_identifier_node import block_messages
from test.support.node_driver import NodeDriver, three_modes

pytestmark = pytest.mark.node
SEED, ROBOT = 7, 'irb6660_205_190'
# Of two links, all in the shipped layout.
NAMES = ('elbow_top.x', 'elbow_top.y', 'elbow_top.z', 'wrist.x', 'wrist.y', 'wrist.z')
LINKS = {'link_3', 'link_5'}
SWING_M = 0.15


@pytest.fixture
def driver(ros_context):
    drivers = []

    def start(**parameters):
        parameters = {'window_s': 20.0, 'hop_s': 20.0, 'max_frequency_hz': 30.0, **parameters}
        drivers.append(NodeDriver(ros_context, **parameters))
        return drivers[-1]

    yield start
    for each in drivers:
        each.close()


def listen(driver, topic, kind, quality=LATCHED):
    heard = []
    driver.peer.create_subscription(kind, topic, heard.append, quality)
    return heard


def identified(driver, names=NAMES, robot=ROBOT):
    """Let a plan of a robot come, then samples; return the window's modes."""
    plans = driver.peer.create_publisher(
        ExcitationPlan, '/excitation_planner/excitation_plan', LATCHED
    )
    plans.publish(ExcitationPlan(plan_hash='1', robot_name=robot))
    deadline = time.monotonic() + 20.0
    while driver.node.watch.robot_name != robot and time.monotonic() < deadline:
        time.sleep(0.05)
    data, _ = three_modes(20.5, 200.0, len(names), SEED)
    driver.send(block_messages(data, 200.0, names))
    driver.wait_received(len(data) // 32)
    driver.finish()
    return driver.results[0].modes


def shapes_of(pictures):
    """Return markers with points, of pictures after the first."""
    return [
        {(marker.ns, marker.header.frame_id): marker for marker in picture.markers}
        for picture in pictures
        if not any(marker.action == Marker.DELETEALL for marker in picture.markers)
    ]


def test_shapes_move_on_the_links_of_the_robot_the_plan_names(driver):
    node = driver(shown_mode=1)
    pictures = listen(node, '/oma_identifier/mode_shapes', MarkerArray)
    modes = identified(node)
    node.collect(3.0)
    shapes = shapes_of(pictures)
    assert len(shapes) > 10
    assert {frame for name, frame in shapes[0] if name == 'mode shape'} == LINKS
    # One mode at a time, fixed to the links as they move.
    markers = [item for shape in shapes for item in shape.items()]
    words = {marker.text for (name, _), marker in markers if name == 'mode'}
    assert len(words) == 1 and f'{modes[0].frequency_hz:.2f} Hz' in words.pop()
    assert all(marker.frame_locked for _, marker in markers)
    # Each ball swings about its sensor by what its shape says, the farthest by 0.15 m.
    layout = shipped_layout(ROBOT, NAMES)
    shape = np.array(modes[0].shape_real) + 1j * np.array(modes[0].shape_imag)
    moved = {'elbow_top': shape[:3], 'wrist': shape[3:]}
    largest = max(np.linalg.norm(way) for way in moved.values())
    for sensor in layout:
        if sensor.name not in moved:
            continue
        balls = [shape['sensors', sensor.frame_id].points[0] for shape in shapes]
        paths = np.array([(ball.x, ball.y, ball.z) for ball in balls])
        swung = np.abs(paths - np.array(sensor.position_m)).max(axis=0)
        expected = SWING_M * np.abs(moved[sensor.name]) / largest
        assert np.all(swung <= expected + 1e-9)
        assert swung == pytest.approx(expected, rel=0.15, abs=1e-3)


@pytest.mark.parametrize(
    ('names', 'robot'),
    [(('a', *NAMES[1:]), ROBOT), (NAMES, 'somebody_elses'), (NAMES, '../robots/' + ROBOT)],
    ids=['another sensor', 'another robot', 'a path'],
)
def test_nothing_is_drawn_where_the_places_are_not_known(driver, names, robot):
    node = driver()
    pictures = listen(node, '/oma_identifier/mode_shapes', MarkerArray)
    assert identified(node, names, robot)
    node.collect(1.0)
    assert pictures and not any(marker.points for each in pictures for marker in each.markers)


def test_every_mode_has_a_plain_number_to_plot(driver):
    node = driver()
    modes = identified(node)
    assert len(modes) == 3
    for mode in modes:
        for field in ('frequency_hz', 'damping_ratio'):
            heard = listen(node, f'/oma_identifier/mode_{mode.id}/{field}', Float64)
            node.collect(1.0)
            assert [message.data for message in heard] == [getattr(mode, field)]


def test_a_check_keeps_its_name_while_it_fails_and_after(driver):
    node = driver()
    heard = listen(node, '/diagnostics', DiagnosticArray, 10)
    node.collect(2.5)
    identified(node)
    node.collect(2.5)
    names = {tuple(status.name for status in message.status) for message in heard}
    assert names == {
        tuple(f'/oma_identifier: {check}' for check in ('samples', 'channels', 'windows', 'node'))
    }
    first, last = heard[0].status[0], heard[-1].status[0]
    assert (first.level, first.message.split()[0]) == (b'\x03', 'NO_DATA')
    assert (last.level, last.message) == (b'\x00', 'OK')
