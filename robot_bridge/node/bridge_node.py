"""The bridge as a ROS node: plans in, joint states out, nothing moves without arm and start."""

from collections.abc import Sequence
import contextlib
from pathlib import Path
import sys
import threading
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.executors import MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.logging import get_logging_directory
from rclpy.parameter import Parameter

from excitation_planner.ros_messages import plan_from_message
from modal_core.errors import BridgeError, ModalAnalysisError
from modal_core.nodes.ros_messages import declare_parameters, LATCHED, parameter_mapping
from modal_core.nodes.run_node import RCLError, run_node
from oma_msgs.msg import BridgeState
from oma_msgs.msg import ExcitationPlan as PlanMessage
from robot_bridge.backends import ROS2_CONTROL
from robot_bridge.bridge import Bridge
from robot_bridge.bridge_settings import LIVE, PARAMETERS, settings_from
from robot_bridge.egm import check_six_axes, RobotFeedback
from robot_bridge.node.joint_publisher_node import JointPublisher
from robot_bridge.node.name_watch_node import NameWatch, STATE_QOS
from robot_bridge.node.operator_desk_node import OperatorDesk
from robot_bridge.node.ros_messages import diagnostic_status, state_message
from robot_bridge.operator import check_fraction
from structural_model.robot_files import load_robot

# Plans; arm, start and reset; abort; life cycle; and what is quick: none waits for another.
N_THREADS = 5
WATCH_S = 0.2


class BridgeNode(LifecycleNode):
    """Plans to a controller or the emulator, through one of the backends.

    Configured, it listens and publishes joint states; active, it answers and can be armed.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__('robot_bridge', **options)
        declare_parameters(self, PARAMETERS)
        self.condition, self.plan_error = 'not configured', ''
        self.configure_error: ModalAnalysisError | None = None
        self.bridge: Bridge | None = None
        self.robot: Any = None
        self._plan: PlanMessage | None = None
        self._waiting_plan: PlanMessage | None = None
        self._clash, self._to_activate = '', False
        self._looking = threading.Lock()
        self.joints = JointPublisher(self)
        self.states = self.create_publisher(BridgeState, '~/state', STATE_QOS)
        self.diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        quick, plans = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
        # Whatever /clock says or does not say: the arm moves in the time of this machine.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.desk = OperatorDesk(
            self, lambda: self.bridge, self._look_around, self._publish_state, quick, steady
        )
        topic = 'excitation_planner/excitation_plan'
        self.create_subscription(PlanMessage, topic, self._on_plan, LATCHED, callback_group=plans)
        watch = MutuallyExclusiveCallbackGroup()
        self.names = NameWatch(self, quick)
        for period_s, action, group in (
            (1.0, self._take_plan, plans),
            (WATCH_S, self._watch_names, watch),
            (0.1, self._publish_state, quick),
            (1.0, self._publish_diagnostics, quick),
        ):
            self.create_timer(period_s, action, callback_group=group, clock=steady)
        self.add_on_set_parameters_callback(self._accept)
        self.add_post_set_parameters_callback(self._take_parameters)

    def begin(self) -> None:
        """Configure, and activate once nobody else has these names, if that is asked for.

        Raises
        ------
        ModalAnalysisError
            It cannot be configured.
        """
        if not self.get_parameter('autostart').value:
            return
        self.trigger_configure()
        if self.configure_error is not None:
            raise self.configure_error
        self._to_activate = True
        self.names.settle()
        self._watch_names()  # before anybody hears of this bridge, if it is alone

    # -- life cycle ----------------------------------------------------------------------------

    def on_configure(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Load the robot, listen to the controller, answer nothing yet."""
        try:
            self._open()
        except ModalAnalysisError as error:
            self._close()
            self.configure_error, self.condition = error, str(error)
            if not self.get_parameter('autostart').value:
                self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        self.configure_error, self.condition = None, 'not active'
        if self._plan is not None:
            self._on_plan(self._plan)  # latched, so it does not come again
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Answer the controller; plans may be armed.  Refused while another has these names."""
        self.names.settle()
        self._look_around()
        if self.bridge is None or self._clash:
            self.get_logger().error(f'not activated: {self._clash or self.condition}')
            return TransitionCallbackReturn.FAILURE
        self.bridge.flow.activate()
        self.condition, self._to_activate = '', False
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Slow down to standstill, then answer no more."""
        self._to_activate = False
        if self.bridge is not None:
            self.bridge.come_to_rest()
        self.condition = 'not active'
        return super().on_deactivate(state)

    def _watch_names(self) -> None:
        """Look for others of these names, and activate when there is time for it."""
        self._look_around()
        if self._to_activate and self.names.settled and not self._clash:
            with contextlib.suppress(RCLError):  # a life cycle manager was quicker
                self.trigger_activate()

    def _look_around(self) -> None:
        with self._looking:
            before, self._clash = self._clash, self.names.others()
            if self._clash and not before:
                self.get_logger().error(f'NAME_CLASH {self._clash}')
            if self.bridge is not None:
                self.bridge.flow.meet(self._clash)

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Give the port back."""
        self._to_activate = False
        self._close()
        self.condition = 'not configured'
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Stop and give the port back, from any state."""
        self._to_activate = False
        self._close()
        self.condition = 'shut down'
        return TransitionCallbackReturn.SUCCESS

    def _open(self) -> None:
        log_file = Path(get_logging_directory()) / time.strftime('egm_%Y%m%d_%H%M%S.mcap')
        settings = settings_from(parameter_mapping(self, PARAMETERS), log_file)
        model = load_robot(settings.robot)
        if settings.backend.name == ROS2_CONTROL:
            self.robot = self._trajectory_robot(settings.backend.trajectory_action)
        else:
            check_six_axes(model.joint_names, model.robot_name)
        # The robot tells its own joint states.
        self.joints.start(model, publish_states=self.robot is None)
        self.bridge = Bridge(settings, model, self._hear, self.joints.tell, self.robot)
        self.bridge.flow.hear = self.desk.hear
        if self.bridge.log is not None:
            self.get_logger().info(f'packets and states go to {self.bridge.log.path}')

    def _trajectory_robot(self, action: str) -> Any:
        try:
            from robot_bridge.node.trajectory_robot_node import TrajectoryRobot
        except ImportError as error:
            raise BridgeError(
                'control_msgs is not installed', where=ROS2_CONTROL, found=error,
                advice='install ros-jazzy-control-msgs; without ROS pip install ./control_msgs',
            ) from error  # fmt: skip
        return TrajectoryRobot(self, action)

    def _close(self) -> None:
        if self.bridge is not None:
            self.bridge.close()
        if self.robot is not None:
            self.robot.close()
        self.robot = None
        self.joints.stop()
        self.bridge = None

    def destroy_node(self) -> None:
        """Stop moving, stop the threads, then the node."""
        self._close()
        super().destroy_node()

    # -- what comes in -------------------------------------------------------------------------

    def _hear(self, feedback: RobotFeedback, receipt_ns: int) -> None:
        bridge = self.bridge
        reference = None
        if bridge is not None and bridge.flow.playing:
            reference = bridge.flow.reference_deg
        self.joints.hear(feedback, receipt_ns, reference)

    def _on_plan(self, message: PlanMessage) -> None:
        self._plan = self._waiting_plan = message
        self._take_plan()

    def _take_plan(self) -> None:
        """Take the plan that came last; one that comes while another is played waits for its end.

        Not even looked at before: that work would be in the way of the replies.
        """
        bridge, message = self.bridge, self._waiting_plan
        if bridge is None or message is None or bridge.flow.busy:
            return
        self._waiting_plan = None
        try:
            told = bridge.take(plan_from_message(message))
            self.plan_error = ''
            self.get_logger().info(told)
        except ModalAnalysisError as error:
            if bridge.flow.busy:  # started just now
                self._waiting_plan = message
                return
            self.plan_error = str(error)
            self.get_logger().error(f'plan refused: {error}', throttle_duration_sec=5.0)

    def _accept(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        bridge = self.bridge
        for parameter in parameters:
            if bridge is not None and parameter.name not in LIVE:
                reason = f'{parameter.name} can be changed before the bridge is configured'
                return SetParametersResult(successful=False, reason=reason)
            if parameter.name == 'speed_override':
                try:
                    check_fraction(float(parameter.value))
                except (ModalAnalysisError, TypeError, ValueError) as error:
                    return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take_parameters(self, parameters: Sequence[Parameter]) -> None:
        """Follow what has been set: parameters set together are set together or not at all."""
        bridge = self.bridge
        for parameter in parameters:
            if parameter.name == 'speed_override' and bridge is not None:
                bridge.flow.set_speed_override(float(parameter.value))

    # -- reports -------------------------------------------------------------------------------

    def _publish_state(self) -> None:
        name = self.get_parameter('backend').value
        condition = '; '.join(part for part in (self.condition, self._clash) if part)
        message = state_message(self.bridge, name, condition)
        message.header.stamp = self.get_clock().now().to_msg()
        self.names.tell()
        self.states.publish(message)

    def _publish_diagnostics(self) -> None:
        name = f'{self.get_fully_qualified_name()}: bridge'
        status = diagnostic_status(name, self.bridge, self.plan_error, self._clash)
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics.publish(message)


def _spin(node: BridgeNode) -> None:
    node.begin()
    executor = MultiThreadedExecutor(N_THREADS)
    executor.add_node(node)
    executor.spin()


def main(args: Sequence[str] | None = None) -> None:
    """Run the bridge until it is stopped."""
    sys.setswitchinterval(0.0005)
    run_node('robot_bridge', BridgeNode, _spin, args)


if __name__ == '__main__':
    main()
