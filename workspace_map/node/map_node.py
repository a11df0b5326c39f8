"""A map as a ROS node: joint states in, modes and limits of a cut at the present pose out."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node

from machining.cut_settings import CutSettings
from modal_core.errors import MapError, ModalAnalysisError, ModelError
from modal_core.files.yaml_file import load_yaml
from modal_core.nodes.newest_joints_node import ArmPose, NewestJoints
from modal_core.nodes.ros_messages import declare_parameters, diagnostic, LATCHED
from modal_core.nodes.run_node import run_node
from oma_msgs.msg import PredictedModes, StabilityLimit
from structural_model import load_layout, load_robot
from workspace_map.live import cut_limit, ModesHere, MotionModes
from workspace_map.map_file import load_map
from workspace_map.node.newest_only import NewestOnly
from workspace_map.node.node_parameters import PARAMETERS
from workspace_map.node.ros_messages import header_of, limit_message, modes_message, placed, Said

DIAGNOSTICS_PERIOD_S = REPEAT_S = LIMIT_PERIOD_S = 1.0
SILENT_S = 2.0
"""Without joint states after which nothing is known; a bridge sends them every 20 ms."""
STILL_RAD = 1e-4
"""Joints that move by less are at rest: no frequency changes by more than 3e-5 of itself."""
STOP_S = 5.0


@dataclass(frozen=True, slots=True)
class Asked:
    """A pose whose limit of a cut is asked for; without modes, the reason why there are none."""

    pose: ArmPose
    here: ModesHere | None
    reason: str = ''


class MapNode(Node):
    """Predicts modes as the arm moves, and once a second while it rests."""

    def __init__(self, **options: Any) -> None:
        super().__init__('modal_map', **options)
        declare_parameters(self, PARAMETERS)
        self.motion = self._load()
        self.cut = self._load_cut()
        self.n_predicted = 0
        self.problem = ''
        self._last: ArmPose | None = None
        self._asked: Asked | None = None
        self._limited: ArmPose | None = None
        self._said_ns = self._heard_ns = 0
        self._modes = self.create_publisher(PredictedModes, '~/predicted_modes', LATCHED)
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.create_timer(DIAGNOSTICS_PERIOD_S, self._publish_diagnostics)
        self._worker: NewestOnly[Asked] | None = None
        if self.motion is None:
            self.get_logger().info('no map is named: nothing is predicted')
            return
        names = self.motion.known.arm.model.joint_names
        self._joints = NewestJoints(self, self._value('joint_states_topic'), names)
        self.create_timer(1.0 / self._value('rate_hz'), self._look)
        if self.cut is not None:
            self._limits = self.create_publisher(StabilityLimit, '~/stability_limit', LATCHED)
            self._worker = NewestOnly(self._find_limit)
            self.create_timer(LIMIT_PERIOD_S, self._ask_limit)

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _load(self) -> MotionModes | None:
        path = self._value('map')
        if not path:
            return None
        robot = self._value('robot')
        layout = load_layout(robot, self._value('sensors'))
        known, _ = load_map(Path(path), load_robot(robot), layout)
        _ = known.fitted  # seconds of work, before anybody waits for it
        return MotionModes(known)

    def _load_cut(self) -> CutSettings | None:
        path = self._value('cut')
        return CutSettings.from_mapping(load_yaml(Path(path)), path) if path else None

    # -- predictions ---------------------------------------------------------------------------

    def _look(self) -> None:
        """Predict where the arm is, if it moved or nothing was said for a while."""
        pose = self._joints.take()
        if pose is None:
            return
        now_ns = self._heard_ns = self.get_clock().now().nanoseconds
        if _rests(self._last, pose) and now_ns - self._said_ns < REPEAT_S * 1e9:
            return
        self._last, self._said_ns = pose, now_ns
        self._modes.publish(self._predicted(pose))

    def _predicted(self, pose: ArmPose) -> PredictedModes:
        assert self.motion is not None  # noqa: S101  nobody looks without
        arm = self.motion.known.arm
        try:
            here = self.motion.at(pose.position)
        except (MapError, ModelError) as error:
            self.problem = str(error)
            self._asked = Asked(pose, None, self.problem)
            message = PredictedModes(robot_name=arm.model.robot_name, reason=self.problem)
            return self._placed(message, pose)
        self.problem, self._asked = '', Asked(pose, here)
        self.n_predicted += 1
        return self._placed(modes_message(arm, here), pose)

    def _placed(self, message: Said, pose: ArmPose) -> Said:
        assert self.motion is not None  # noqa: S101
        header = header_of(pose.stamp, self._value('base_frame'))
        return placed(message, header, self.motion.known.arm.model.joint_names, pose.position)

    # -- limits of a cut -----------------------------------------------------------------------

    def _ask_limit(self) -> None:
        asked = self._asked
        if self._worker is None or asked is None or _rests(self._limited, asked.pose):
            return
        self._limited = asked.pose
        self._worker.submit(asked)

    def _find_limit(self, asked: Asked) -> None:
        """Publish the limit at a pose; in a thread of its own."""
        message = self._placed(self._limit(asked), asked.pose)
        try:
            self._limits.publish(message)
        except rclpy_implementation.RCLError:
            # Told to stop while it was computed.
            if self.context.ok():
                raise

    def _limit(self, asked: Asked) -> StabilityLimit:
        if asked.here is None or self.cut is None:
            return StabilityLimit(reason=asked.reason)
        try:
            return limit_message(cut_limit(asked.here.predicted, self.cut))
        except (ModalAnalysisError, ArithmeticError, ValueError) as error:
            return StabilityLimit(reason=str(error))

    # -- health --------------------------------------------------------------------------------

    def _found(self) -> tuple[bytes, str]:
        """Return level and message of /diagnostics."""
        if self.motion is None:
            return DiagnosticStatus.OK, 'OK: no map is named'
        if self.get_clock().now().nanoseconds - self._heard_ns > SILENT_S * 1e9:
            return DiagnosticStatus.STALE, 'NO_JOINT_STATES nobody tells where the arm stands'
        if self.problem:
            return DiagnosticStatus.WARN, f'POSE_UNKNOWN {self.problem}'
        return DiagnosticStatus.OK, 'OK'

    def _publish_diagnostics(self) -> None:
        (level, said), own = self._found(), self.get_fully_qualified_name()
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        values = {'predictions': self.n_predicted}
        message.status = [diagnostic(f'{own}: map', said, level, values, own)]
        self._diagnostics.publish(message)

    def destroy_node(self) -> None:
        """End the thread, then the node."""
        if self._worker is not None:
            self._worker.stop(STOP_S)
        super().destroy_node()


def _rests(before: ArmPose | None, now: ArmPose) -> bool:
    return before is not None and np.allclose(
        before.position, now.position, rtol=0.0, atol=STILL_RAD
    )


def main(args: Sequence[str] | None = None) -> None:
    """Run the node until it is told to stop."""
    run_node('modal_map', MapNode, args=args)


if __name__ == '__main__':
    main()
