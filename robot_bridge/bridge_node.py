"""The bridge as a ROS node: plans in, joint states out, nothing moves without arm and start."""

from array import array
from collections import deque
from collections.abc import Sequence
import contextlib
from pathlib import Path
import sys
import threading
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from excitation_planner.limits import check_limits, PlanLimits
from excitation_planner.ros_messages import plan_from_message
from modal_core.errors import BridgeError, ModalAnalysisError, PlanError
from oma_msgs.msg import BridgeState
from oma_msgs.msg import ExcitationPlan as PlanMessage
from oma_msgs.srv import ArmPlan
from robot_bridge.backend import Backend
from robot_bridge.backends import BACKENDS, BackendSettings, make_backend
from robot_bridge.clock_map import ClockMap
from robot_bridge.egm_feedback import RobotFeedback
from robot_bridge.egm_link import EgmLink, Packet
from robot_bridge.operator_flow import FlowSettings
from robot_bridge.packet_log import PacketLog
from robot_bridge.plan_path import PlanPath
from robot_bridge.plan_player import PlayerSettings, Reference
from robot_bridge.ros_messages import diagnostic_status, state_message
from robot_bridge.session_check import Judgement, SessionCheck, SessionLimits
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.robot_files import load_robot

NANOSECONDS = 1_000_000_000
RCLError = rclpy_implementation.RCLError
RELIABLE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
HEARTBEAT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
SPEED_SLACK = 1.2
LAST_REPLIES_S = 0.2
PARAMETERS: tuple[tuple[str, Any, str], ...] = (
    ('autostart', True, 'configure and activate as soon as the node is up'),
    ('robot', 'irb6660_205_190', 'robot of config/robots, or its folder'),
    ('backend', 'emulator', f'one of {", ".join(BACKENDS)}'),
    ('method', 'egm', 'emulator only: egm guidance, or a rapid program'),
    ('guidance_enabled', False, 'let EGM guidance move a real arm'),
    ('dry_run', True, 'go through everything and send nothing to the controller'),
    ('bind_address', '127.0.0.1', 'interface to listen on; wildcards are refused'),
    ('port', 6510, 'EGM port'),
    ('controller_address', '127.0.0.1', 'the only host listened to'),
    ('rapid_file', 'AmaExcitation.mod', 'RAPID backends: where the module of a plan goes'),
    ('rws_address', '', 'RAPID backends: web services, host or host:port; empty: by hand'),
    ('rws_user', 'Default User', 'account of the web services'),
    ('rws_password', 'robotics', 'its password'),
    ('cycle_s', 0.004032, 'period of the controller [s]'),
    ('link_timeout_s', 0.012, 'silence that counts as a lost link [s]'),
    ('most_missed_cycles', 3, 'packets in a row that may be missing while moving'),
    ('heartbeat_timeout_s', 0.13, 'silence of the operator that stops; 0: none asked'),
    ('start_tolerance_deg', 0.2, 'distance from the start pose allowed at start [deg]'),
    ('max_following_error_deg', 2.0, 'distance from the reference that stops [deg]'),
    ('ramp_in_s', 1.0, 'time over which the amplitude grows [s]'),
    ('stop_ramp_s', 0.05, 'time from an abort to standstill [s]'),
    ('point_speed_m_s', 0.25, 'plans with a faster point of the arm are refused [m/s]'),
    ('packet_log', '', 'MCAP file for every EGM packet; empty: none'),
    ('speed_override', 1.0, '0..1, live: scales the motion'),
)
FIXED = frozenset(name for name, _, _ in PARAMETERS) - {'speed_override', 'autostart'}


class BridgeNode(LifecycleNode):
    """Plans to a controller or the emulator, through one of the backends.

    Configured, it listens and publishes joint states; active, it answers and can be armed.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__('robot_bridge', **options)
        for name, default, text in PARAMETERS:
            self.declare_parameter(name, default, ParameterDescriptor(description=text))
        self.condition = 'not configured'
        self.configure_error: ModalAnalysisError | None = None
        self.model: FlexibleJointModel | None = None
        self.backend: Backend | None = None
        self.link: EgmLink | None = None
        self.log: PacketLog | None = None
        self.clock_map = ClockMap()
        self.plan_error = ''
        self._plan: PlanMessage | None = None
        self._joints: deque[tuple[int, RobotFeedback]] = deque(maxlen=4096)
        self._last_joints: tuple[int, np.ndarray] | None = None
        self._closing = threading.Event()
        self._publisher: threading.Thread | None = None
        self.add_on_set_parameters_callback(self._accept)
        self._make_interfaces()

    # -- life cycle ----------------------------------------------------------------------------

    def on_configure(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Load the robot, listen to the controller, answer nothing yet."""
        try:
            self._open()
        except ModalAnalysisError as error:
            self._close()
            self.configure_error, self.condition = error, str(error)
            if not self._value('autostart'):
                self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        self.configure_error, self.condition = None, 'not active'
        if self._plan is not None:
            self._on_plan(self._plan)  # latched, so it does not come again
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Answer the controller; plans may be armed."""
        self.backend.flow.activate()
        self.condition = ''
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Slow down to standstill, then answer no more."""
        self._come_to_rest()
        self.condition = 'not active'
        return super().on_deactivate(state)

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Give the port back."""
        self._close()
        self.condition = 'not configured'
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop and give the port back, from any state."""
        self.condition = 'shut down'
        return self.on_cleanup(state)

    def _open(self) -> None:
        value = self._value
        self.model = load_robot(value('robot'))
        self.backend = make_backend(self._backend_settings(), self.model)
        self.backend.flow.set_speed_override(value('speed_override'))
        self.backend.flow.deactivate()
        self.backend.flow.mute()
        self.link = EgmLink(
            value('bind_address'),
            value('port'),
            SessionCheck(self._session_limits()),
            self._answer,
            self.backend.abort,
            self.backend.flow.poll,
            log=self._add_to_log,
        )
        self.log = PacketLog(Path(value('packet_log'))) if value('packet_log') else None
        self._closing.clear()
        self._publisher = threading.Thread(target=self._publish_joints, daemon=True)
        self._publisher.start()
        self.link.start()

    def _come_to_rest(self) -> None:
        """Stop the motion, see it through, then answer no more."""
        flow = self.backend.flow
        flow.deactivate()
        deadline_s = time.monotonic() + flow.settings.player.stop_ramp_s + LAST_REPLIES_S
        while flow.moving and flow.connected and time.monotonic() < deadline_s:
            time.sleep(flow.settings.cycle_s)
        # The reference to stand still must have left.
        time.sleep(5.0 * flow.settings.cycle_s)
        flow.mute()

    def _close(self) -> None:
        if self.backend is not None:
            self._come_to_rest()
        if self.link is not None:
            self.link.close()
        self._closing.set()
        if self._publisher is not None:
            self._publisher.join(timeout=1.0)
        if self.log is not None:
            self.log.close()
        self.link = self.backend = self.log = self._publisher = None

    def destroy_node(self) -> None:
        """Stop moving, stop the threads, then the node."""
        self._close()
        super().destroy_node()

    # -- set-up --------------------------------------------------------------------------------

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _backend_settings(self) -> BackendSettings:
        value = self._value
        return BackendSettings(
            name=value('backend'),
            method=value('method'),
            guidance_enabled=value('guidance_enabled'),
            controller_address=value('controller_address'),
            rapid_file=Path(value('rapid_file')),
            rws_address=value('rws_address'),
            rws_user=value('rws_user'),
            rws_password=value('rws_password'),
            flow=FlowSettings(
                cycle_s=value('cycle_s'),
                link_timeout_s=value('link_timeout_s'),
                most_missed_cycles=value('most_missed_cycles'),
                heartbeat_timeout_s=value('heartbeat_timeout_s'),
                start_tolerance_deg=value('start_tolerance_deg'),
                max_following_error_deg=value('max_following_error_deg'),
                dry_run=value('dry_run'),
                player=PlayerSettings(
                    ramp_in_s=value('ramp_in_s'), stop_ramp_s=value('stop_ramp_s')
                ),
            ),
        )

    def _session_limits(self) -> SessionLimits:
        speed = np.degrees(self.model.limits.velocity) * SPEED_SLACK
        return SessionLimits(
            cycle_s=self._value('cycle_s'),
            max_speed_deg_s=tuple(speed.tolist()),
            controller_address=self._value('controller_address'),
        )

    def _make_interfaces(self) -> None:
        services, quick = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
        self.states = self.create_publisher(BridgeState, '~/state', LATCHED)
        self.joint_states = self.create_publisher(JointState, '/joint_states', RELIABLE)
        self.diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.create_subscription(
            PlanMessage,
            'excitation_planner/excitation_plan',
            self._on_plan,
            LATCHED,
            callback_group=MutuallyExclusiveCallbackGroup(),
        )
        self.create_subscription(
            Empty, '~/heartbeat', self._on_heartbeat, HEARTBEAT, callback_group=quick
        )
        self.create_service(ArmPlan, '~/arm', self._on_arm, callback_group=services)
        for name, action in (
            ('start', lambda backend: backend.start(time.monotonic())),
            ('abort', lambda backend: backend.abort('aborted by the operator')),
            ('reset', lambda backend: backend.flow.reset()),
        ):
            self.create_service(
                Trigger, f'~/{name}', self._trigger(name, action), callback_group=services
            )
        self.create_timer(0.1, self._publish_state, callback_group=quick)
        self.create_timer(1.0, self._publish_diagnostics, callback_group=quick)

    # -- the controller ------------------------------------------------------------------------

    def _answer(
        self, feedback: RobotFeedback, judgement: Judgement, now_s: float, receipt_ns: int
    ) -> Reference | None:
        self._joints.append((self.clock_map.stamp_ns(feedback.time_us, receipt_ns), feedback))
        return self.backend.answer(feedback, judgement, now_s)

    def _add_to_log(self, packet: Packet) -> None:
        if self.log is not None:
            self.log.add(packet)

    def _publish_joints(self) -> None:
        while not self._closing.wait(0.02):
            while self._joints and self.context.ok():
                stamp_ns, feedback = self._joints.popleft()
                angles = self.model.to_serial(np.radians(feedback.joints_deg))
                with contextlib.suppress(RCLError):  # the context may end between the two
                    self.joint_states.publish(self._joint_state(stamp_ns, angles))

    def _joint_state(self, stamp_ns: int, angles: np.ndarray) -> JointState:
        message = JointState(name=list(self.model.joint_names))
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, NANOSECONDS)
        message.position = array('d', angles.tobytes())
        last = self._last_joints
        if last is not None and 0 < stamp_ns - last[0] < NANOSECONDS:
            # EGM reports no speed: the difference of the angles, half a cycle late.
            rate = (angles - last[1]) / ((stamp_ns - last[0]) / NANOSECONDS)
            message.velocity = array('d', rate.tobytes())
        self._last_joints = (stamp_ns, angles)
        return message

    # -- the operator --------------------------------------------------------------------------

    def _on_plan(self, message: PlanMessage) -> None:
        self._plan = message
        if self.backend is None:
            return
        try:
            plan = plan_from_message(message)
            if plan.robot_name != self.model.robot_name:
                raise PlanError(
                    'plan is for another robot',
                    found=plan.robot_name,
                    expected=self.model.robot_name,
                )
            if plan.joint_names != self.model.joint_names:
                raise PlanError('plan has other joints', found=plan.joint_names)
            limits = PlanLimits(
                self.model,
                point_speed_m_s=self._value('point_speed_m_s'),
                guided=self.backend.guides,
            )
            check_limits(plan.trajectory, limits)
            path = PlanPath.from_trajectory(
                plan.plan_hash, plan.trajectory, self.model.to_controller
            )
            told = self._require_backend().take(plan, path)
            self.plan_error = ''
            self.get_logger().info(told)
        except ModalAnalysisError as error:
            self.plan_error = str(error)
            self.get_logger().error(f'plan refused: {error}')

    def _on_heartbeat(self, _: Empty) -> None:
        if self.backend is not None:
            self.backend.flow.heartbeat(time.monotonic())

    def _on_arm(self, request: ArmPlan.Request, response: ArmPlan.Response) -> ArmPlan.Response:
        try:
            flow = self._require_backend().flow
            flow.arm(request.plan_hash, request.timeout_s, time.monotonic())
            response.accepted, response.message = True, flow.reason
        except ModalAnalysisError as error:
            response.accepted, response.message = False, str(error)
        self.get_logger().info(f'arm: {response.message}')
        return response

    def _trigger(self, name: str, action: Any) -> Any:
        def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            try:
                backend = self._require_backend()
                action(backend)
                response.success, response.message = True, backend.flow.reason
            except ModalAnalysisError as error:
                response.success, response.message = False, str(error)
            self.get_logger().info(f'{name}: {response.message}')
            self._publish_state()
            return response

        return answer

    def _require_backend(self) -> Backend:
        if self.backend is None:
            raise BridgeError('the bridge is not configured', advice='configure it first')
        return self.backend

    def _accept(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == 'speed_override':
                try:
                    if self.backend is not None:
                        self.backend.flow.set_speed_override(float(parameter.value))
                except (ModalAnalysisError, TypeError, ValueError) as error:
                    return SetParametersResult(successful=False, reason=str(error))
            elif self.backend is not None and parameter.name in FIXED:
                reason = f'{parameter.name} can be changed before the bridge is configured'
                return SetParametersResult(successful=False, reason=reason)
        return SetParametersResult(successful=True)

    # -- reports -------------------------------------------------------------------------------

    def _publish_state(self) -> None:
        message = state_message(self.backend, self.link, self._value('backend'), self.condition)
        message.header.stamp = self.get_clock().now().to_msg()
        self.states.publish(message)

    def _publish_diagnostics(self) -> None:
        status = diagnostic_status(self.backend, self.link, self.log, self.plan_error)
        status.name = f'{self.get_fully_qualified_name()}: bridge'
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics.publish(message)


def main(args: Sequence[str] | None = None) -> None:
    """Run the bridge until it is stopped."""
    sys.setswitchinterval(0.0005)
    rclpy.init(args=args)
    node = None
    try:
        node = BridgeNode()
        if node.get_parameter('autostart').value:
            node.trigger_configure()
            if node.configure_error is not None:
                raise node.configure_error
            node.trigger_activate()
        executor = MultiThreadedExecutor(3)
        executor.add_node(node)
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except rclpy_implementation.RCLError:
        # Told to stop while it was still starting.
        if rclpy.ok():
            raise
    except (ModalAnalysisError, ParameterException) as error:
        sys.stderr.write(f'robot_bridge: {error}\n')
        raise SystemExit(2) from error
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
