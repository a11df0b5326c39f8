"""The emulated cell as a ROS node: ABB controller on UDP, accelerometers on topics."""

from collections.abc import Mapping, Sequence
import contextlib
import math
from pathlib import Path
import queue
import sys
import threading
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
from rcl_interfaces.msg import SetParametersResult
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from abb_emulator.cell import ArmSide, MotorSide, SensorBlock
from abb_emulator.egm import LinkFaults, UdpClient
from abb_emulator.node.emulator_parameters import (
    cell_settings,
    guidance_settings,
    PARAMETERS,
    start_angles_deg,
)
from abb_emulator.node.fault_desk import Fault, FaultDesk
from abb_emulator.node.ros_messages import truth_message
from abb_emulator.rapid import ProgramTask
from abb_emulator.recorder import Recorder
from abb_emulator.rws import RwsServer, Station
from modal_core.errors import BridgeError, SettingsError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.nodes.ros_messages import (
    declare_parameters,
    diagnostic,
    LATCHED,
    parameter_mapping,
)
from modal_core.nodes.run_node import run_node
from modal_core.work.real_time import ask_for_real_time
from modal_recordings.messages import encode
from oma_msgs.msg import AccelerationBlock, ModalParameters
from oma_msgs.srv import InjectFault
from robot_bridge.egm import check_six_axes
from structural_model.robot_files import load_layout, load_robot

RCLError = rclpy_implementation.RCLError
BLOCKS = QoSProfile(depth=200, reliability=ReliabilityPolicy.RELIABLE)
SAMPLES = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.BEST_EFFORT)
BLOCK_TOPIC, SPEED_TOPIC = 'acceleration_block', 'spindle_speed_rpm'
POSE_MOVED_RAD = 2e-3
CATCH_UP_S = 0.002
CONTROLLER_PRIORITY = 30
LATEST_S = 1.0


class EmulatorNode(Node):
    """Runs the controller in one thread and the arm in another, both in real time."""

    def __init__(self, **options: Any) -> None:
        super().__init__('abb_emulator', **options)
        declare_parameters(self, PARAMETERS)
        values = parameter_mapping(self, PARAMETERS)
        self._lock = threading.Lock()
        self._to_arm: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._closing = threading.Event()
        self.n_late = self.n_slips = 0
        self.plant_s = self.plant_of_s = 0.0
        self._make_cell(values)
        self._make_operator(values)
        self._make_interfaces()
        if values['start_program']:
            self.task.start()
        self._threads = [
            threading.Thread(target=self._run_motors, name='controller', daemon=True),
            threading.Thread(target=self._run_arm, name='arm', daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def _make_cell(self, values: Mapping[str, Any]) -> None:
        """Make controller, arm and sensors, standing at the start pose."""
        self.model = load_robot(values['robot'])
        check_six_axes(self.model.joint_names, self.model.robot_name)
        self.layout = load_layout(values['robot'], values['sensors_file'])
        self.settings = cell_settings(values)
        start_deg = start_angles_deg(values, self.model)
        self.faults = LinkFaults(np.random.default_rng(self.settings.seed + 1))
        self.client = UdpClient(
            (values['sensor_address'], values['sensor_port']),
            self.faults,
            values['local_address'],
        )
        self.start_ns = time.time_ns()
        self.motors = MotorSide(
            self.model,
            start_deg,
            self.client,
            self.settings,
            self.start_ns / NANOSECONDS_PER_SECOND,
        )
        self.recorder = Recorder.of(self.layout)
        self.names = [channel.name for channel in self.recorder.channels]
        self.arm = ArmSide(self.model, self.recorder.channels, start_deg, self.settings)
        self._truth_pose = np.full(self.model.n_joints, math.inf)

    def _make_operator(self, values: Mapping[str, Any]) -> None:
        """Make what an operator has: program, key and panel, faults, web services."""
        controller = self.motors.controller
        self.guidance = guidance_settings(values)
        self.task = ProgramTask(
            controller, self.guidance, np.random.default_rng(self.settings.seed + 2)
        )
        self.desk = FaultDesk(controller, self.faults, self.arm.sensors, tuple(self.names))
        for text in values['faults']:
            if text:
                self.desk.put(Fault.from_text(text))
        controller.set_automatic(values['automatic'])
        controller.confirm_automatic()
        if not controller.set_speed_ratio(values['speed_ratio']):
            raise SettingsError(
                'out of range', where='speed_ratio', found=values['speed_ratio'], expected='0..1'
            )
        if values['module']:
            self.task.load_file(Path(values['module']))
        self.rws: RwsServer | None = None
        if values['rws.port']:
            self.rws = RwsServer(
                Station(controller, self.task, self._lock), values['rws.address'],
                values['rws.port'], values['rws.user'], values['rws.password'],
                values['rws.version'],
            )  # fmt: skip
            if self.rws.fingerprint:
                self.get_logger().info(f'rws_certificate: {self.rws.fingerprint}')

    def _make_interfaces(self) -> None:
        self._topics = {BLOCK_TOPIC: self.create_publisher(AccelerationBlock, BLOCK_TOPIC, BLOCKS)}
        for port in self.recorder.imus:
            self._topics[port.topic] = self.create_publisher(Imu, port.topic, SAMPLES)
        self.spindle = None
        if self.settings.process.active:
            self.spindle = self.create_publisher(Float64, SPEED_TOPIC, BLOCKS)
        self.truth = self.create_publisher(ModalParameters, '~/true_modes', LATCHED)
        self.diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        for name, action in (
            ('start_program', self._start_program),
            ('stop_program', self._stop_program),
            ('reset_program', self._reset_program),
            ('load_module', self._load_module),
            ('emergency_stop', self._emergency_stop),
            ('motors_on', self._motors_on),
            ('confirm_automatic', self._confirm_automatic),
        ):
            self.create_service(Trigger, f'~/{name}', action)
        self.create_service(SetBool, '~/automatic', self._automatic)
        self.create_service(InjectFault, '~/inject_fault', self._inject_fault)
        self.add_on_set_parameters_callback(self._on_parameters)
        self.create_timer(0.5, self._publish_truth)
        self.create_timer(1.0, self._publish_diagnostics)

    # -- parameters ----------------------------------------------------------------------------

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == 'speed_ratio':
                with self._lock:
                    if not self.motors.controller.set_speed_ratio(float(parameter.value)):
                        reason = 'speed_ratio must be above 0 and at most 1'
                        return SetParametersResult(successful=False, reason=reason)
        return SetParametersResult(successful=True)

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    # -- threads -------------------------------------------------------------------------------

    def _run_motors(self) -> None:
        """Run the controller's cycles at their times; when late, run faster, never skip."""
        ask_for_real_time(CONTROLLER_PRIORITY)
        cycle_s = self.settings.controller.cycle_s
        due_s = time.perf_counter()
        while not self._closing.is_set():
            with self._lock:
                self.desk.tick(cycle_s)
                motion = self.motors.cycle()
            self._to_arm.put(motion)
            due_s += cycle_s
            wait_s = due_s - time.perf_counter()
            if wait_s < -LATEST_S:
                due_s = time.perf_counter()
                self.n_slips += 1
            elif wait_s < 0.0:
                self.n_late += 1
                # The sensor's answer to the last message must have time to arrive: a real
                # controller is never late, and reads one answer in each cycle.
                wait_s = CATCH_UP_S
            time.sleep(max(wait_s, 0.0))

    def _run_arm(self) -> None:
        while not self._closing.is_set():
            motion = self._to_arm.get()
            if motion is None:
                return
            begin_s = time.thread_time()
            blocks = self.arm.take(motion)
            self.plant_s += time.thread_time() - begin_s
            self.plant_of_s += len(motion[0]) / self.settings.sample_rate_hz
            for block in blocks:
                self._publish_block(block)

    def _publish_block(self, block: SensorBlock) -> None:
        process = self.arm.arm.process
        if self.spindle is not None and process is not None:
            time_s = block.first_index / self.settings.sample_rate_hz
            self._publish(self.spindle, Float64(data=float(process.speed_rpm(time_s))))
        # Serialised here: a fifth of what rclpy takes for a message of its own.
        for topic, measurement in self.recorder.measurements(
            BLOCK_TOPIC,
            block.first_index,
            block.acceleration,
            self.settings.sample_rate_hz,
            self.start_ns,
        ):
            for message in encode(measurement, topic):
                self._publish(self._topics[topic], message.data)

    def _publish(self, publisher: Any, message: Any) -> None:
        if self.context.ok() and not self._closing.is_set():
            with contextlib.suppress(RCLError):  # the context may end between the two
                publisher.publish(message)

    # -- operator ------------------------------------------------------------------------------

    def _start_program(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            response.success = self.task.start()
        response.message = 'running' if response.success else 'motors off or already running'
        return response

    def _stop_program(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            self.task.stop()
        response.success = True
        return response

    def _reset_program(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            response.success = self.task.reset()
        response.message = 'at main' if response.success else 'program is running'
        return response

    def _load_module(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        try:
            with self._lock:
                module = self.task.load_file(Path(self._value('module')))
        except BridgeError as error:
            response.message = str(error)
            return response
        response.success, response.message = True, f'module {module.name} loaded'
        return response

    def _automatic(self, request: Any, response: SetBool.Response) -> SetBool.Response:
        with self._lock:
            self.motors.controller.set_automatic(request.data)
            response.message = self.motors.controller.operating_mode
        response.success = True
        return response

    def _confirm_automatic(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            response.success = self.motors.controller.confirm_automatic()
            response.message = self.motors.controller.operating_mode
        return response

    def _inject_fault(self, request: Any, response: InjectFault.Response) -> InjectFault.Response:
        fault = Fault(request.fault, request.value, request.duration_s, request.target)
        try:
            with self._lock:
                response.message = self.desk.put(fault)
            response.accepted = True
        except BridgeError as error:
            response.message = str(error)
        return response

    def _emergency_stop(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            self.motors.controller.emergency_stop()
        response.success = True
        return response

    def _motors_on(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            self.motors.controller.release_emergency_stop()
            response.success = self.motors.controller.switch_motors_on()
        return response

    # -- reports -------------------------------------------------------------------------------

    def _publish_truth(self) -> None:
        """Publish the true modes of the pose, at every channel, whenever it has moved."""
        pose = self.arm.pose
        if np.max(np.abs(pose - self._truth_pose)) < POSE_MOVED_RAD:
            return
        self._truth_pose = pose.copy()
        channels = self.layout.channels
        message = truth_message(self.arm.model, pose, channels, self.settings.sample_rate_hz)
        message.header.stamp = self.get_clock().now().to_msg()
        self.truth.publish(message)

    def _publish_diagnostics(self) -> None:
        controller = self.motors.controller
        session = controller.session
        values = {
            'session': session.phase.name if session is not None else 'none',
            'rapid_running': controller.running,
            'queued_datagrams': self.client.n_queued,
            'late_cycles': self.n_late,
            'slips': self.n_slips,
            'plant_real_time_factor': f'{self.real_time_factor:.1f}',
            'arm_backlog_cycles': self._to_arm.qsize(),
            'operating_mode': controller.operating_mode,
            'speed_ratio': controller.speed_ratio,
            'faults': ', '.join(self.desk.active),
            'last_event': controller.events[-1] if controller.events else '',
        }
        on = controller.motors_on
        status = diagnostic(
            f'{self.get_fully_qualified_name()}: controller',
            'EMULATOR_RUNNING' if on else 'MOTORS_OFF',
            DiagnosticStatus.OK if on else DiagnosticStatus.WARN,
            values,
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics.publish(message)

    @property
    def real_time_factor(self) -> float:
        """Time simulated over processor time spent on the arm."""
        return self.plant_of_s / max(self.plant_s, 1e-9)

    def destroy_node(self) -> None:
        """Stop the threads, then the node."""
        self._closing.set()
        self._to_arm.put(None)
        for thread in self._threads:
            thread.join(timeout=2.0)
        # Plainly: the context the logger needs has ended by now.
        sys.stderr.write(
            f'{self.get_name()}: arm simulated for {self.plant_of_s:.0f} s, real-time factor '
            f'{self.real_time_factor:.1f}; {self.n_late} cycles late, {self.n_slips} slips\n'
        )
        if self.rws is not None:
            self.rws.close()
        self.client.close()
        super().destroy_node()


def main(args: Sequence[str] | None = None) -> None:
    """Run the emulated cell until it is stopped."""
    sys.setswitchinterval(0.0005)
    run_node('abb_emulator', EmulatorNode, args=args)


if __name__ == '__main__':
    main()
