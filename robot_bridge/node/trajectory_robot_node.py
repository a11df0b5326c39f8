"""A robot under ros2_control: joint states in, trajectories out by FollowJointTrajectory."""

from array import array
from collections.abc import Callable
import threading
import time
from typing import Any

from builtin_interfaces.msg import Duration
from rclpy.action import ActionClient
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.duration import Duration as ClockDuration
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

from control_msgs.action import FollowJointTrajectory
from modal_core.errors import BridgeError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from robot_bridge.egm import SessionLimits
from robot_bridge.player import PlanPath
from robot_bridge.trajectory import JointGoal, JointLink
from structural_model.flexible_joint_model import FlexibleJointModel

STATES = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
ANSWER_S, LEAD_S = 2.0, 0.3
"""Longest wait for the controller's answer; time it has to take a trajectory in."""
CODES = {
    value: name
    for name, value in vars(FollowJointTrajectory.Result).items()
    if name.isupper() and isinstance(value, int)
}
CANCELLED = 5  # action_msgs/GoalStatus.STATUS_CANCELED


class TrajectoryRobot:
    """Talks to a joint trajectory controller; see :class:`TrajectoryControl`.

    Parameters
    ----------
    node : LifecycleNode
        Whose ``joint_states`` it listens to.
    action : str
        Name of the action.
    """

    def __init__(self, node: LifecycleNode, action: str) -> None:
        self._node, self._name = node, action
        self.on_end: Callable[[str], None] = lambda _: None
        self.link: JointLink | None = None
        self._goal: Any = None
        self._group = ReentrantCallbackGroup()
        self._client = ActionClient(
            node, FollowJointTrajectory, action, callback_group=self._group
        )
        self._states = node.create_subscription(
            JointState, 'joint_states', self._hear, STATES,
            callback_group=MutuallyExclusiveCallbackGroup(),
        )  # fmt: skip

    def connect(
        self,
        model: FlexibleJointModel,
        limits: SessionLimits,
        answer: Any,
        alarm: Callable[[str], None],
        idle: Callable[[float], None],
    ) -> JointLink:
        """Return the link that the joint states go to from now on."""
        self.link = JointLink(model, limits, answer, alarm, idle)
        return self.link

    def close(self) -> None:
        """Listen no more."""
        self._node.destroy_subscription(self._states)
        self._client.destroy()

    # -- what a backend asks for ---------------------------------------------------------------

    @property
    def update_rate_hz(self) -> float:
        """Rate of the joint states, which a controller publishes with each of its updates."""
        return self.link.update_rate_hz if self.link is not None else 0.0

    def check(self, goal: JointGoal) -> None:
        """Refuse a robot that is not there.

        Raises
        ------
        BridgeError
            No such action, or no joint states.
        """
        if not self._client.wait_for_server(ANSWER_S):
            raise BridgeError(
                'no controller plays trajectories', where=self._name,
                advice='is joint_trajectory_controller active? set trajectory_action',
            )  # fmt: skip
        if self.link is None or self.link.feedback is None:
            raise BridgeError('no joint states', where='joint_states')

    def run(self, goal: JointGoal, path: PlanPath, check_wanted: Callable[[], None]) -> None:
        """Have a trajectory played.

        Raises
        ------
        BridgeError
            It is not wanted any more, or the controller refuses it or does not answer.
        """
        link = self.link
        if link is None:
            raise BridgeError('not connected', where=self._name)
        message = _message(goal)
        check_wanted()
        begins = self._node.get_clock().now() + ClockDuration(nanoseconds=int(LEAD_S * 1e9))
        message.trajectory.header.stamp = begins.to_msg()
        asked = self._client.send_goal_async(message)
        try:
            handle = self._answer_to(asked)
        except BridgeError:
            # Whatever it may still accept is given up at once.
            asked.add_done_callback(_give_up)
            raise
        if not handle.accepted:
            raise BridgeError('the controller refuses the trajectory', where=self._name)
        self._goal = handle
        link.begin(path, begins.nanoseconds)
        handle.get_result_async().add_done_callback(lambda done: self._ended(handle, done))

    def stop(self) -> None:
        """Have the trajectory given up.

        Raises
        ------
        BridgeError
            The controller does not answer, or does not give it up.
        """
        handle = self._goal
        if handle is None:
            return
        answer = self._answer_to(handle.cancel_goal_async())
        if not answer.goals_canceling and self._goal is handle:
            raise BridgeError('the controller does not give the trajectory up', where=self._name)

    # -- inside --------------------------------------------------------------------------------

    def _hear(self, message: JointState, info: dict[str, Any]) -> None:
        stamp, number = message.header.stamp, info['publication_sequence_number']
        if self.link is not None:
            self.link.take(
                stamp.sec * NANOSECONDS_PER_SECOND + stamp.nanosec, message.name, message.position,
                time.time_ns(), number,
            )  # fmt: skip

    def _ended(self, handle: Any, done: Future) -> None:
        """Take the controller's word on how a trajectory ended."""
        if handle is not self._goal:
            return
        self._goal = None
        found = done.result()
        result = found.result
        if found.status == CANCELLED:
            self.on_end('the controller has given the trajectory up')
        elif result.error_code != FollowJointTrajectory.Result.SUCCESSFUL:
            code = CODES.get(result.error_code, str(result.error_code))
            self.on_end(f'the controller stopped: {code} {result.error_string}'.strip())
        if self.link is not None:
            self.link.end(at_its_end=result.error_code == FollowJointTrajectory.Result.SUCCESSFUL)

    def _answer_to(self, future: Future) -> Any:
        """Return an answer; the executor has other threads that bring it."""
        there = threading.Event()
        future.add_done_callback(lambda _: there.set())
        if not there.wait(ANSWER_S):
            raise BridgeError('the controller does not answer', where=self._name)
        return future.result()


def _give_up(asked: Future) -> None:
    """Cancel a goal whose acceptance came too late."""
    handle = asked.result()
    if handle is not None and handle.accepted:
        handle.cancel_goal_async()


def _message(goal: JointGoal) -> FollowJointTrajectory.Goal:
    """Return the goal; without tolerances the controller's own hold."""
    message = FollowJointTrajectory.Goal()
    message.trajectory.joint_names = list(goal.joint_names)
    rows = zip(goal.time_s, goal.position, goal.velocity, goal.acceleration, strict=True)
    message.trajectory.points = [
        JointTrajectoryPoint(
            positions=array('d', position.tobytes()),
            velocities=array('d', velocity.tobytes()),
            accelerations=array('d', acceleration.tobytes()),
            time_from_start=_duration(time_s),
        )
        for time_s, position, velocity, acceleration in rows
    ]
    return message


def _duration(time_s: float) -> Duration:
    seconds, nanoseconds = divmod(round(time_s * NANOSECONDS_PER_SECOND), NANOSECONDS_PER_SECOND)
    return Duration(sec=int(seconds), nanosec=int(nanoseconds))
