"""The identifier node takes the edge of the excitation from the plan that is being played."""

import time

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from modal_core.nodes.ros_messages import LATCHED
from oma_msgs.msg import BridgeState, ExcitationPlan
from test.support.node_driver import NodeDriver

pytestmark = pytest.mark.node
PATIENCE_S = 60.0


class Cell:
    """A planner and a bridge, as far as the identifier listens to them."""

    def __init__(self, peer):
        self._plan = peer.create_publisher(
            ExcitationPlan, '/excitation_planner/excitation_plan', LATCHED
        )
        self._state = peer.create_publisher(BridgeState, '/robot_bridge/state', LATCHED)

    def plans(self, plan_hash, signal='band_limited_noise', band_high_hz=60.0):
        self._plan.publish(
            ExcitationPlan(plan_hash=plan_hash, signal=signal, band_high_hz=band_high_hz)
        )

    def is_in(self, state, plan_hash, dry_run=False):
        self._state.publish(BridgeState(state=state, plan_hash=plan_hash, dry_run=dry_run))


@pytest.fixture
def start(ros_context):
    drivers = []

    def begin(**parameters):
        driver = NodeDriver(ros_context, **parameters)
        drivers.append(driver)
        return driver, Cell(driver.peer)

    yield begin
    for driver in drivers:
        driver.close()


def upper_end(driver):
    return driver.node.pipeline.settings.max_frequency_hz


def wait_for(driver, expected):
    deadline = time.monotonic() + PATIENCE_S
    while upper_end(driver) != pytest.approx(expected) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert upper_end(driver) == pytest.approx(expected)


def test_the_band_follows_the_plan_that_is_played_and_no_other(start):
    driver, cell = start()
    tracker = driver.node.pipeline.tracker
    cell.plans('first')
    cell.is_in(BridgeState.ARMED, 'first')
    cell.is_in(BridgeState.RUNNING, 'first', dry_run=True)
    cell.is_in(BridgeState.RUNNING, 'another')
    cell.is_in(BridgeState.RUNNING, 'first')
    wait_for(driver, 57.0)
    cell.plans('pulses', signal='random_pulses')
    cell.plans('third', band_high_hz=40.0)
    cell.is_in(BridgeState.RUNNING, 'first')
    wait_for(driver, 57.0)
    cell.is_in(BridgeState.RUNNING, 'pulses')
    wait_for(driver, None)
    cell.is_in(BridgeState.RUNNING, 'third')
    wait_for(driver, 38.0)
    cell.is_in(BridgeState.HOLDING, 'third')
    wait_for(driver, None)
    assert driver.node.pipeline.tracker is tracker, 'the modes keep their ids'


def test_a_band_that_is_stated_stays(start):
    driver, cell = start(max_frequency_hz=80.0)
    cell.plans('first')
    cell.is_in(BridgeState.RUNNING, 'first')
    deadline = time.monotonic() + PATIENCE_S
    while driver.node.watch.edge_hz is None and time.monotonic() < deadline:
        time.sleep(0.01)
    assert driver.node.watch.edge_hz == 60.0
    assert upper_end(driver) == 80.0
