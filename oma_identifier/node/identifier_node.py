"""The identifier as a ROS node: samples in, modal parameters out after each window."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import SetParametersResult
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from std_srvs.srv import Trigger

from modal_core.channel import Channel
from modal_core.errors import MessageError, SettingsError
from modal_core.layouts.shipped_layouts import shipped_layout
from modal_core.measurements import Measurement
from modal_core.nodes.polled_group_node import PolledGroup
from modal_core.nodes.ros_messages import (
    declare_parameters,
    diagnostic,
    LATCHED,
    parameter_mapping,
)
from modal_core.nodes.run_node import run_node
from modal_core.words.printable import printable
from modal_core.words.reasons import say_reasons
from modal_recordings.messages import BLOCK, JOINT_STATE
from oma_identifier.covariance import below_edge
from oma_identifier.intake import in_order, TopicIntake
from oma_identifier.methods import method_named
from oma_identifier.motion import load_robot_motion
from oma_identifier.node.cell_topics import cells, is_of_cell
from oma_identifier.node.checks import (
    CHANNELS,
    Check,
    checks,
    ERROR,
    NODE,
    OK,
    SAMPLES,
    STALE,
    WARN,
    WINDOWS,
)
from oma_identifier.node.excitation_watch_node import ExcitationWatch
from oma_identifier.node.findings import quality_findings
from oma_identifier.node.mode_topics_node import ModeTopics
from oma_identifier.node.node_parameters import (
    load_layout_file,
    PARAMETERS,
    SETTINGS,
    settings_from,
)
from oma_identifier.node.polled_topic_node import PolledTopic
from oma_identifier.node.ros_messages import (
    MESSAGE_CLASSES,
    modal_parameters,
    prediction_from,
    stabilisation_diagram,
)
from oma_identifier.node.shape_view_node import ShapeView
from oma_identifier.node.spindle_topic_node import SpindleTopic
from oma_identifier.node.worker import IdentificationWorker, Job
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.result import WindowResult
from oma_identifier.settings import IdentificationSettings
from oma_identifier.tracking import CheckpointFile, ModeTracker
from oma_msgs.msg import ModalParameters, PredictedModes, StabilisationDiagram

POLL_PERIOD_S = 0.05
DISCOVERY_PERIOD_S = 0.25
DIAGNOSTICS_PERIOD_S = 1.0
SAMPLE_DEPTH = 8000
BLOCK_DEPTH = 1024
FINISH_TIMEOUT_S = 60.0
OF_NODE = 'CHECKPOINT'
DIAGNOSTIC_LEVELS = {
    OK: DiagnosticStatus.OK,
    WARN: DiagnosticStatus.WARN,
    ERROR: DiagnosticStatus.ERROR,
    STALE: DiagnosticStatus.STALE,
}
RESTARTED = 'restarted'
"""Flag of the first window after a restart from a checkpoint; numbers run on."""


class IdentifierNode(Node):
    """Buffers responses and publishes modal parameters after each window."""

    def __init__(self, **options: Any) -> None:
        super().__init__('oma_identifier', **options)
        declare_parameters(self, PARAMETERS)
        self.layout = load_layout_file(self._value('layout_file'))
        robot = self._value('robot')
        self.robot = load_robot_motion(robot) if robot else None
        if self.robot is not None and self.layout is not None:
            self.layout.check_links(self.robot.link_names, robot)
        self.intake = TopicIntake()
        self.problems: dict[str, str] = {}
        checkpoint = self._value('checkpoint_file')
        self._checkpoint = CheckpointFile(Path(checkpoint)) if checkpoint else None
        self._restarted = False
        self.pipeline = IdentificationPipeline(
            settings_from(self._settings()),
            self.layout,
            self._load_tracker(),
            self.robot,
            keeps_record=False,
        )
        self._polled = PolledGroup()
        self._spindle = SpindleTopic(self, self._polled, self._value('spindle_topic'))
        self._subscriptions_of: dict[str, tuple[str, PolledTopic]] = {}
        self._last_result: WindowResult | None = None
        self.worker = IdentificationWorker(self.publish_result, self._window_failed)
        self._make_interfaces()
        self.watch = ExcitationWatch(
            self, self._value('plan_topic'), self._value('bridge_topic'), self._edge_changed
        )
        self._publish_last()

    def _make_interfaces(self) -> None:
        self._modal = self.create_publisher(ModalParameters, '~/modal_parameters', LATCHED)
        self._diagram = self.create_publisher(
            StabilisationDiagram, '~/stabilisation_diagram', LATCHED
        )
        self._shapes = ShapeView(
            self, self._value('base_frame'), self._placed, lambda: self._value('shown_mode')
        )
        self._numbers = ModeTopics(self)
        predicted = self._value('predicted_modes_topic')
        self.create_subscription(PredictedModes, predicted, self._take_prediction, LATCHED)
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.create_service(Trigger, '~/finish', self._on_finish)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._apply_parameters)
        if self.get_logger().get_effective_level() <= LoggingSeverity.DEBUG:
            say_reasons(self.get_logger().debug)
        self.create_timer(POLL_PERIOD_S, self._poll)
        self.create_timer(DISCOVERY_PERIOD_S, self._discover)
        self.create_timer(DIAGNOSTICS_PERIOD_S, self._publish_diagnostics)

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _settings(self) -> dict[str, object]:
        return parameter_mapping(self, SETTINGS)

    # -- input -----------------------------------------------------------------------------

    def _discover(self) -> None:
        """Subscribe to topics of responses that have appeared, and to the joint states."""
        named = {self.resolve_topic_name(topic) for topic in self._value('topics') if topic}
        joints = self.resolve_topic_name(self._value('joint_states_topic'))
        topics = self.get_topic_names_and_types()
        self._spindle.look(topics)
        others = cells(self, topics)
        if others is None:
            return
        for topic, types in topics:
            if topic in self._subscriptions_of:
                continue
            message_type = next((name for name in types if name in MESSAGE_CLASSES), None)
            if message_type is None:
                continue
            if message_type == JOINT_STATE:
                wanted = topic == joints
            else:
                wanted = (
                    topic in named if named else is_of_cell(topic, self.get_namespace(), others)
                )
            if wanted:
                self._subscribe(topic, message_type)

    def _subscribe(self, topic: str, message_type: str) -> None:
        if not self.count_publishers(topic):
            return
        depth = BLOCK_DEPTH if message_type == BLOCK else SAMPLE_DEPTH
        subscription = PolledTopic(self, self._polled, topic, MESSAGE_CLASSES[message_type], depth)
        self._subscriptions_of[topic] = (message_type, subscription)
        if message_type != JOINT_STATE:
            self.pipeline.buffer.expect(topic)
        self.get_logger().info(f'listening to {topic} ({message_type})')

    def _poll(self) -> None:
        """Drain all topics, decode, and hand complete windows to the worker."""
        found: list[Measurement] = []
        # Joint states first, so that they are there when a window closes.
        for topic, (message_type, subscription) in sorted(
            self._subscriptions_of.items(), key=lambda item: item[1][0] != JOINT_STATE
        ):
            raws = [raw for raw, _ in subscription.take()]
            found += self.intake.decode(raws, message_type, topic)
        # A late poll holds seconds of every topic: side by side again, as they came.
        for measurement in in_order(found):
            self.pipeline.add(measurement)
        self.pipeline.add_speed(self._spindle.take(self.pipeline.buffer.now_ns))
        for window in self.pipeline.windows():
            if not self.worker.submit(Job(self.pipeline, window)):
                self.get_logger().warning(
                    f'window {window.index} skipped: identification cannot keep up',
                    throttle_duration_sec=10.0,
                )

    def _take_prediction(self, message: PredictedModes) -> None:
        """Keep what a map expects, for the ids of the modes."""
        try:
            self.pipeline.tracker.predictions.add(prediction_from(message))
        except MessageError as error:
            self.get_logger().warning(str(error), throttle_duration_sec=10.0)

    def _on_finish(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Flush the samples that are held, identify the partial last window, begin anew."""
        self._poll()
        before = self.worker.n_done
        for window in self.pipeline.finish():
            self.worker.submit(Job(self.pipeline, window), may_skip=False)
        response.success = self.worker.wait_idle(FINISH_TIMEOUT_S)
        response.message = f'{self.worker.n_done - before} windows identified'
        return response

    # -- output ----------------------------------------------------------------------------

    def publish_result(self, result: WindowResult) -> None:
        """Publish a window's result and keep it for the next start."""
        base_frame = self._value('base_frame')
        result = self._marked(result)
        self._last_result = result
        message = modal_parameters(result, base_frame, self.worker.n_skipped)
        try:
            self._modal.publish(message)
            self._diagram.publish(stabilisation_diagram(result, base_frame))
            self._shapes.take(result)
            self._numbers.take(result)
        except rclpy_implementation.RCLError:
            # Told to stop while this window was identified: it is kept for the next start.
            if self.context.ok():
                raise
        self._save(message)

    def _placed(self, names: tuple[str, ...]) -> Sequence[Channel]:
        """Return channels with their places: of the layout, else of the robot that is named."""
        placed = [channel for channel in self.pipeline.buffer.channels if channel.frame_id]
        layout = None if placed else shipped_layout(self.watch.robot_name, names)
        return placed if layout is None else layout.channels

    def _window_failed(self, reason: str) -> None:
        self.problems['WINDOW_FAILED'] = reason
        self.get_logger().error(reason)

    def _publish_diagnostics(self) -> None:
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        message.status = [self._status(check) for check in checks(self._found())]
        self._diagnostics.publish(message)

    def findings(self) -> list[tuple[str, str]]:
        """Return code and text of all that /diagnostics names now."""
        return [finding for found in self._found().values() for finding in found]

    def _found(self) -> dict[str, list[tuple[str, str]]]:
        """Return code and text of what each check found."""
        result, counters = self._last_result, self.pipeline.buffer.counters
        samples = [
            ('MESSAGE_REFUSED', f'{count} of {topic}: {self.intake.last_refusal[topic]}')
            for topic, count in self.intake.n_refused.items()
        ]
        if not self.intake.n_messages:
            samples.append(('NO_DATA', 'no samples received yet'))
        samples += [(reason.upper(), counters.describe(reason)) for reason in counters.reasons]
        windows = [item for item in self.problems.items() if item[0] != OF_NODE]
        if self.worker.n_skipped:
            windows.append(('WINDOW_SKIPPED', f'{self.worker.n_skipped} windows skipped'))
        if result is not None and not result.quality.identifiable:
            windows.append(('NOT_IDENTIFIABLE', result.quality.reason))
        node = [item for item in self.problems.items() if item[0] == OF_NODE]
        full_names = [
            f'{namespace.rstrip("/")}/{name}'
            for name, namespace in self.get_node_names_and_namespaces()
        ]
        if full_names.count(self.get_fully_qualified_name()) > 1:
            node.append(('NAME_CLASH', 'another node has the same name'))
        quality = [] if result is None else quality_findings(result.quality)
        return {SAMPLES: samples, CHANNELS: quality, WINDOWS: windows, NODE: node}

    def _status(self, check: Check) -> DiagnosticStatus:
        counts = self.intake.n_messages.items() if check.name == SAMPLES else ()
        values: dict[str, str] = {}
        for code, text in check.findings:
            values[code] = f'{values[code]}; {text}' if code in values else text
        values |= {f'messages {topic}': str(count) for topic, count in counts}
        if check.name == WINDOWS:
            values['windows'] = str(self.worker.n_done)
        name = f'{self.get_fully_qualified_name()}: {check.name}'
        level = DIAGNOSTIC_LEVELS[check.level]
        return diagnostic(name, check.message, level, values, self.get_fully_qualified_name())

    # -- parameters and checkpoint ---------------------------------------------------------

    def _check_parameters(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        values = self._settings()
        values.update({p.name: p.value for p in parameters if p.name in values})
        try:
            method_named(settings_from(values).method)
        except SettingsError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _apply_parameters(self, parameters: Sequence[Parameter]) -> None:
        """Begin anew with the new settings; the modes keep their ids."""
        if not {parameter.name for parameter in parameters} & set(self._settings()):
            return
        self._begin(below_edge(settings_from(self._settings()), self.watch.edge_hz))

    def _edge_changed(self, edge_hz: float | None) -> None:
        """Begin anew where the excitation now ends; what was collected is identified first."""
        settings = below_edge(settings_from(self._settings()), edge_hz)
        if settings == self.pipeline.settings:
            return
        self._poll()
        for window in self.pipeline.finish():
            self.worker.submit(Job(self.pipeline, window))
        edge = 'no plan' if edge_hz is None else f'a plan that excites up to {edge_hz:g} Hz'
        band = f'up to {settings.max_frequency_hz:g} Hz' if settings.max_frequency_hz else 'free'
        self.get_logger().info(f'{edge} is played: band {band}')
        self._begin(settings)

    def _begin(self, settings: IdentificationSettings) -> None:
        n_windows = self.pipeline.buffer.n_windows
        self.pipeline = IdentificationPipeline(
            settings, self.layout, self.pipeline.tracker, self.robot, keeps_record=False
        )
        self.pipeline.buffer.n_windows = n_windows
        for topic, (message_type, _) in self._subscriptions_of.items():
            if message_type != JOINT_STATE:
                self.pipeline.buffer.expect(topic)

    def _load_tracker(self) -> ModeTracker | None:
        if self._checkpoint is None:
            return None
        try:
            return self._checkpoint.tracker()
        except SettingsError as error:
            self._distrust(self._checkpoint.path, error)
            return None

    def _publish_last(self) -> None:
        """Serve the last result again, and number the windows on from it."""
        if self._checkpoint is None:
            return
        try:
            kept = self._checkpoint.last_result()
            if kept is None:
                return
            message = deserialize_message(kept, ModalParameters)
            self._modal.publish(message)
        except (ValueError, SettingsError, rclpy_implementation.RCLError, RuntimeError) as error:
            self._distrust(self._checkpoint.last, error)
            return
        self.pipeline.buffer.n_windows = message.window_index + 1
        self._restarted = True

    def _distrust(self, path: Path, error: Exception) -> None:
        self.problems['CHECKPOINT'] = f'{path} not used: {printable(error, 300)}'
        self.get_logger().warning(self.problems['CHECKPOINT'])

    def _marked(self, result: WindowResult) -> WindowResult:
        """Say of the first window after a restart that it is: what lies between is not known."""
        if not self._restarted:
            return result
        self._restarted = False
        quality = replace(result.quality, flags=(*result.quality.flags, RESTARTED))
        return replace(result, quality=quality)

    def _save(self, message: ModalParameters) -> None:
        """Keep ids and the last result for the next start."""
        if self._checkpoint is None:
            return
        try:
            self._checkpoint.save(self.pipeline.tracker, serialize_message(message))
            self.problems.pop('CHECKPOINT', None)
        except OSError as error:
            self.problems['CHECKPOINT'] = f'{self._checkpoint.path} not written: {error}'

    def destroy_node(self) -> None:
        """Stop the worker, then the node."""
        self.worker.stop(5.0)
        if self._checkpoint is not None:
            self._checkpoint.close()
        super().destroy_node()


def main(args: Sequence[str] | None = None) -> None:
    """Run the node until it is told to stop."""
    run_node('oma_identifier', IdentifierNode, args=args)


if __name__ == '__main__':
    main()
