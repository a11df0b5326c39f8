"""Bridge and joint trajectory controller as processes: the same gates as with any other robot."""

import threading
import time

import numpy as np
import pytest

pytestmark = pytest.mark.node
DISCONNECTED, IDLE, ARMED, RUNNING, HOLDING, ABORTED = 0, 1, 2, 3, 5, 6
BRIDGE = {
    'backend': 'ros2_control', 'dry_run': False, 'cycle_s': 0.01, 'link_timeout_s': 0.4,
    'heartbeat_timeout_s': 0.4, 'point_speed_m_s': 0.25,
}  # fmt: skip


@pytest.fixture(scope='module', autouse=True)
def messages():
    try:
        from control_msgs.action import FollowJointTrajectory  # noqa: F401
    except ImportError:
        pytest.skip('control_msgs is not installed: pip install ./control_msgs')


@pytest.fixture(scope='module')
def joints(model):
    return {'joints': list(model.joint_names), 'start': model.pose('P1').tolist()}


@pytest.fixture
def start(drivers, domain, operator, joints):
    """Return a function that starts controller and bridge; they are stopped after the test."""
    running = []

    def begin(bridge=None, **controller):
        operator.states.clear()
        operator.joints.clear()
        running.append(
            drivers.NodeProcess('trajectory_controller', domain, **{**joints, **controller})
        )
        running.append(drivers.NodeProcess('robot_bridge', domain, **{**BRIDGE, **(bridge or {})}))
        operator.until(lambda: operator.states, 'state')
        return running

    yield begin
    for item in reversed(running):
        said = item.stop()
        assert item.name != 'robot_bridge' or 'Traceback' not in said


def released(operator, pulses):
    operator.hold()
    operator.until_connected()
    operator.offer(pulses)
    answer = operator.arm(pulses.plan_hash)
    assert answer.accepted, answer.message
    return operator


def positions(operator):
    return np.array([list(item.position) for item in operator.joints])


@pytest.mark.smoke
def test_a_released_plan_is_played_to_its_end(start, operator, pulses, plan_of_pulses, model):
    start()
    operator.hold()
    operator.until_connected()
    operator.offer(pulses)
    assert not operator.arm('0' * 64).accepted
    assert not operator.arm(pulses.plan_hash, controller='another').accepted
    assert operator.start().success is False
    released(operator, pulses)
    operator.joints.clear()
    assert operator.start().success
    state = operator.until_state(HOLDING, patience_s=30.0)
    assert state.progress == 1.0
    moved = np.ptp(positions(operator), axis=0)
    wanted = np.ptp(plan_of_pulses.position, axis=0)
    np.testing.assert_allclose(moved, wanted, rtol=0.2, atol=2e-4)
    end = positions(operator)[-1]
    np.testing.assert_allclose(end, plan_of_pulses.position[-1], atol=2e-3)


def stopped_early(operator, plan_of_pulses):
    time.sleep(1.0)
    operator.joints.clear()
    operator.until(lambda: len(operator.joints) > 30, 'joint states')
    rest = positions(operator)
    assert np.all(np.ptp(rest[10:], axis=0) < 1e-6)


def test_the_heartbeat_lost_gives_the_trajectory_up(start, operator, pulses, plan_of_pulses):
    start()
    released(operator, pulses)
    assert operator.start().success
    operator.until_state(RUNNING, patience_s=10.0)
    time.sleep(1.0)
    operator.hold(False)
    state = operator.until_state(ABORTED, patience_s=5.0)
    assert 'heartbeat' in state.reason
    stopped_early(operator, plan_of_pulses)


def test_an_abort_gives_it_up_and_latches_until_reset(start, operator, pulses, plan_of_pulses):
    start()
    released(operator, pulses)
    assert operator.start().success
    time.sleep(1.5)
    assert operator.abort().success
    operator.until_state(ABORTED, patience_s=5.0)
    stopped_early(operator, plan_of_pulses)
    assert not operator.arm(pulses.plan_hash).accepted
    assert operator.reset().success


WRONG = {
    'tolerance': ({'stuck_after_s': 1.0, 'path_tolerance': 0.0005}, 'PATH_TOLERANCE_VIOLATED'),
    'frozen': ({'stuck_after_s': 1.0, 'path_tolerance': 1.0}, 'axis'),
    'silent': ({'silent_after_s': 1.0}, 'link lost'),
}


@pytest.mark.parametrize('case', WRONG)
def test_what_goes_wrong_meanwhile_ends_it_with_the_reason(start, operator, pulses, case):
    settings, words = WRONG[case]
    start(**settings)
    released(operator, pulses)
    assert operator.start().success
    operator.until_state(ABORTED, patience_s=15.0)
    assert words in operator.last.reason


def test_a_controller_that_refuses_leaves_the_arm_where_it_is(start, operator, pulses):
    start(accepts=False)
    released(operator, pulses)
    answer = operator.start()
    assert not answer.success and 'refuses the trajectory' in answer.message
    assert np.all(np.ptp(positions(operator), axis=0) == 0.0)


def test_a_controller_that_accepts_too_late_plays_nothing(start, operator, pulses):
    start(answers_after_s=4.0)
    released(operator, pulses)
    answer = operator.start()
    assert not answer.success and 'does not answer' in answer.message
    assert operator.last.state == ABORTED
    time.sleep(4.0)
    operator.joints.clear()
    operator.until(lambda: len(operator.joints) > 100, 'joint states')
    assert np.all(np.ptp(positions(operator), axis=0) < 1e-6)


def test_an_arm_elsewhere_moves_nowhere(start, operator, pulses, joints):
    start(start=[v + 0.01 * (k == 0) for k, v in enumerate(joints['start'])])
    released(operator, pulses)
    answer = operator.start()
    assert not answer.success and 'axis 1' in answer.message
    assert np.all(np.ptp(positions(operator), axis=0) == 0.0)


def test_a_dry_run_sends_nothing(start, operator, pulses):
    start(bridge={'dry_run': True})
    released(operator, pulses)
    assert operator.start().success
    time.sleep(2.0)
    assert np.all(np.ptp(positions(operator), axis=0) == 0.0)


class Stranger:
    """A second publisher of joint states, that says the same place all the time."""

    def __init__(self, operator, joints, position, late_s=0.0):
        from sensor_msgs.msg import JointState

        self.make = lambda: JointState(name=joints['joints'], position=list(position))
        self.node, self.late_s = operator.node, late_s
        self.publisher = self.node.create_publisher(JointState, 'joint_states', 10)
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.publish, daemon=True)
        self.thread.start()

    def publish(self):
        while not self.ended.wait(0.01):
            message = self.make()
            stamp_ns = self.node.get_clock().now().nanoseconds - int(1e9 * self.late_s)
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
            self.publisher.publish(message)

    def close(self):
        self.ended.set()
        self.thread.join()
        self.node.destroy_publisher(self.publisher)


@pytest.mark.parametrize('late_s', [0.0, 0.05, -0.05])
def test_a_second_publisher_at_the_start_pose_hides_no_arm_that_is_elsewhere(
    start, operator, pulses, joints, late_s
):
    away = [v + 0.2 * (k == 0) for k, v in enumerate(joints['start'])]
    start(start=away)
    operator.hold()
    operator.until_connected()
    stranger = Stranger(operator, joints, joints['start'], late_s)
    try:
        operator.until_state(ABORTED, patience_s=10.0)
        assert 'joint states' in operator.last.reason
        operator.offer(pulses)
        assert not operator.arm(pulses.plan_hash).accepted
        assert not operator.start().success
    finally:
        stranger.close()
    time.sleep(0.2)
    operator.joints.clear()
    operator.until(lambda: len(operator.joints) > 30, 'joint states')
    assert np.allclose(positions(operator), away, rtol=0.0, atol=1e-6)
    operator.until(lambda: operator.reset().success, 'reset')
    answer = operator.arm(pulses.plan_hash)
    assert answer.accepted, answer.message


def test_a_second_publisher_stops_a_run(start, operator, pulses, plan_of_pulses, joints):
    start()
    released(operator, pulses)
    assert operator.start().success
    operator.until_state(RUNNING, patience_s=10.0)
    time.sleep(1.0)
    stranger = Stranger(operator, joints, joints['start'])
    try:
        operator.until_state(ABORTED, patience_s=5.0)
        assert 'joint states' in operator.last.reason
    finally:
        stranger.close()
    stopped_early(operator, plan_of_pulses)
