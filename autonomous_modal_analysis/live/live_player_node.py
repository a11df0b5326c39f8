"""Records plans that a person plays on the robot: nothing here releases or starts a motion.

A plan is published and shown with its hash.  Whoever is at the robot brings it to the start pose,
holds to run, releases that very hash at the bridge and starts it; the recording follows the
bridge's state, and keeps only motions that came to their end.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import time
from typing import Any, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rclpy.node import Node

from autonomous_modal_analysis.live.operator_node import REFUSED
from autonomous_modal_analysis.live.recorder_node import RecorderNode
from autonomous_modal_analysis.live.spinning_node import ros_context, spinning
from excitation_planner.plan import ExcitationPlan
from excitation_planner.ros_messages import plan_to_message
from modal_core.channel import SensorLayout
from modal_core.errors import BridgeError
from modal_core.nodes.ros_messages import LATCHED
from modal_core.work.progress import Progress
from modal_recordings.messages import JOINT_STATE
from oma_identifier.node import cells, is_of_cell
from oma_identifier.node.ros_messages import MESSAGE_CLASSES
from oma_msgs.msg import BridgeState
from oma_msgs.msg import ExcitationPlan as PlanMessage
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.robot_writer import robot_content

POLL_S = 0.05
DISCOVERY_S = 30.0
TAKEN_S = 30.0
REST_S = 1.0
# What is recorded from before the release was heard of.
HELD_S = 2.0
PLAN_TOPIC = 'excitation_planner/excitation_plan'
BRIDGE = 'robot_bridge'
# The bridge's references are of the same type.
JOINTS = 'joint_states'
Value = TypeVar('Value')


@contextmanager
def live_player(
    model: FlexibleJointModel,
    tell: Callable[[str], None],
    namespace: str = '',
    layout: SensorLayout | None = None,
) -> Iterator['LivePlayer']:
    """Yield a player in the ROS domain of this shell, for the cell in a namespace."""
    with ros_context() as context:
        name = namespace.strip('/')
        node = LivePlayer(model, tell, layout, context=context, namespace=name)
        with spinning(node) as player:
            yield player


class LivePlayer(Node):
    """Publishes plans one by one and records what comes of them.

    It hears and serves the cell in its own namespace.  Spin it in an executor of its own;
    :meth:`play` waits for people and is called from another thread only.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot, for its controller angles.
    tell : callable
        Takes what the person at the robot has to know.
    layout : SensorLayout or None
        Sensors of the robot, which recordings carry beside it.

    Attributes
    ----------
    attached : dict of str to bytes
        Files that recordings carry, by name.
    """

    note = 'recorded on the robot'
    options = 'live'

    def __init__(
        self,
        model: FlexibleJointModel,
        tell: Callable[[str], None],
        layout: SensorLayout | None = None,
        **options: Any,
    ) -> None:
        super().__init__('ama_campaign', **options)
        self._model, self._tell = model, tell
        self.attached = robot_content(model, layout)
        self._state: BridgeState | None = None
        self._refusal = ''
        self._bridge = self.resolve_topic_name(BRIDGE)
        self.plan_topic = self.resolve_topic_name(PLAN_TOPIC)
        self._plans = self.create_publisher(PlanMessage, PLAN_TOPIC, LATCHED)
        self.create_subscription(BridgeState, f'{BRIDGE}/state', self._take_state, LATCHED)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._take_diagnostics, 10)

    def play(self, plan: ExcitationPlan, path: Path, progress: Progress) -> None:
        """Offer a plan and wait until a person has played it; leave its recording.

        Raises
        ------
        BridgeError
            No bridge, one that only pretends, no sensors, or the bridge does not take the plan.
        """
        topics = self.sensors()
        self.publish(plan)
        self._wait('bridge', lambda: self._state, DISCOVERY_S)
        self._wait(
            'plan at the bridge',
            lambda: self._state and self._state.plan_hash == plan.plan_hash,
            TAKEN_S,
            lambda: self._refusal,
        )
        if self._state is not None and self._state.dry_run:
            raise BridgeError('the bridge runs dry', advice='start it with dry_run:=false')
        self._tell(self._instructions(plan))
        while not self._recorded(plan, path, topics, progress):
            pass

    def publish(self, plan: ExcitationPlan) -> None:
        """Offer a plan to the bridge."""
        self._plans.publish(plan_to_message(plan))

    def _recorded(
        self,
        plan: ExcitationPlan,
        path: Path,
        topics: dict[str, type[Any]],
        progress: Progress,
    ) -> bool:
        """Record one attempt; return whether the plan came to its end."""
        recorder = RecorderNode(
            path,
            {**topics, self.plan_topic: PlanMessage},
            (self.plan_topic,),
            held_s=HELD_S,
            attached=self.attached,
            context=self.context,
        )
        recorder.keep = False
        with spinning(recorder):
            self._until({BridgeState.RUNNING}, plan, recorder, progress)
            self._tell('the arm moves; recording')
            ended = self._until(
                {BridgeState.HOLDING, BridgeState.IDLE, BridgeState.ABORTED},
                plan,
                recorder,
                progress,
            )
            recorder.keep = ended.state == BridgeState.HOLDING
            if recorder.keep:
                time.sleep(REST_S)
        if recorder.failure:
            raise BridgeError(recorder.failure)
        if not recorder.keep:
            self._tell(f'not recorded: {ended.reason}. Reset, then release and start it again.')
        return recorder.keep

    def _until(
        self,
        states: set[int],
        plan: ExcitationPlan,
        recorder: RecorderNode,
        progress: Progress,
    ) -> BridgeState:
        """Wait for a state as long as it takes; recording begins with the release."""
        while True:
            state = self._state
            assert state is not None  # noqa: S101 - play() has waited for it
            if state.plan_hash != plan.plan_hash:
                raise BridgeError(
                    'the bridge took another plan',
                    found=state.plan_hash[:12],
                    expected=plan.plan_hash[:12],
                    advice='stop other planners; the campaign goes on when started again',
                )
            if state.state in (BridgeState.ARMED, BridgeState.RUNNING):
                recorder.begin()
            progress(state.progress)
            if state.state in states:
                return state
            time.sleep(POLL_S)

    def sensors(self) -> dict[str, type[Any]]:
        """Return the topics to record: all responses of the cell, and its joint states.

        Raises
        ------
        BridgeError
            There are none.
        """
        found: dict[str, type[Any]] = {}
        joints = self.resolve_topic_name(JOINTS)

        def complete() -> bool:
            topics = self.get_topic_names_and_types()
            others = cells(self, topics)
            if others is None:
                return False
            found.clear()
            for topic, types in topics:
                known = next((name for name in types if name in MESSAGE_CLASSES), None)
                own = topic == joints or (
                    known != JOINT_STATE and is_of_cell(topic, self.get_namespace(), others)
                )
                if known is not None and own and self.count_publishers(topic):
                    found[topic] = MESSAGE_CLASSES[known]
            return joints in found and len(found) > 1

        place = f'ROS domain {os.environ.get("ROS_DOMAIN_ID", "0")}'
        if self.get_namespace() != '/':
            place += f', namespace {self.get_namespace()}'
        self._wait(f'joint states and accelerations in {place}', complete, DISCOVERY_S)
        return found

    def _instructions(self, plan: ExcitationPlan) -> str:
        angles = np.degrees(self._model.to_controller(plan.start_position))
        pose = ', '.join(f'{angle:.3f}' for angle in angles)
        speed = 1e3 * plan.peak_point_speed
        controller = self._state.controller if self._state is not None else ''
        return (
            f'at the robot: bring it to {pose} deg (controller angles). The motion takes'
            f' {plan.duration_s:g} s, its fastest point {speed:.0f} mm/s. Make sure that its'
            f' controller is {controller}. Then release, hold to run with the token it answers,'
            ' and start:\n'
            f'  ros2 service call {self._bridge}/arm oma_msgs/srv/ArmPlan'
            f' "{{plan_hash: {plan.plan_hash}, controller: \'{controller}\', timeout_s: 30}}"\n'
            f'  ros2 topic pub -r 20 {self._bridge}/heartbeat oma_msgs/msg/Heartbeat'
            ' "{token: TOKEN}"\n'
            f'  ros2 service call {self._bridge}/start oma_msgs/srv/StartPlan "{{token: TOKEN}}"'
        )

    def _wait(
        self,
        what: str,
        value: Callable[[], Value | None],
        timeout_s: float,
        reason: Callable[[], str] = lambda: '',
    ) -> Value:
        deadline = time.monotonic() + timeout_s
        while True:
            found = value()
            if found:
                return found
            if time.monotonic() > deadline:
                raise BridgeError(f'no {what} within {timeout_s:g} s', found=reason() or None)
            time.sleep(POLL_S)

    def _take_state(self, state: BridgeState) -> None:
        self._state = state

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.startswith(f'{self._bridge}:'):
                _, refused, reason = status.message.partition(REFUSED)
                self._refusal = reason.strip() if refused else ''
