"""Play a recording on the topics it was recorded from, in its own time."""

from collections.abc import Sequence
import contextlib
import importlib
from pathlib import Path
import threading
import time
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool, Trigger

from modal_core.errors import ModalAnalysisError, RecordingError
from modal_core.layouts.layout_file import layout_from_file
from modal_core.nodes.ros_messages import declare_parameters, LATCHED, parameter_mapping, stamp
from modal_core.nodes.run_node import RCLError, run_node
from modal_core.settings.schema import from_parameters
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.of_robot import as_on_arm
from modal_recordings.open_recording import open_recording, Recording
from oma_msgs.msg import BridgeState
from robot_bridge.node.replay_parameters import PARAMETERS
from robot_bridge.operator import FlowState
from robot_bridge.playback_settings import PlaybackSettings
from robot_bridge.recording import DueMessage, parse_remap, Playback

RELIABLE = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
CLOCK_PERIOD_S = 0.01
LAST_WORDS_S = 30.0


class ReplayNode(Node):
    """The replay backend: one thread publishes, the executor serves pause, step and state."""

    def __init__(self, **options: Any) -> None:
        super().__init__('replay', **options)
        declare_parameters(self, PARAMETERS)
        self.recording = self._open()
        self.playback = self._make_playback()
        self.done = threading.Event()
        self.failure = ''
        self.n_published = 0
        self.largest_lateness_s = 0.0
        self._closing = threading.Event()
        self._gate = threading.Condition()
        self._paused = bool(self._value('start_paused'))
        self._steps = 0
        self._first_ns: int | None = None
        self._now_ns = 0
        # Not self._publishers: rclpy keeps its own list under that name.
        self._outputs: dict[str, Publisher] = {}
        self.states = self.create_publisher(BridgeState, '~/state', LATCHED)
        self.clock_publisher = (
            self.create_publisher(Clock, '/clock', 10) if self._value('publish_clock') else None
        )
        self.create_service(SetBool, '~/pause', self._on_pause)
        self.create_service(Trigger, '~/step', self._on_step)
        self.create_timer(0.2, self._publish_state)
        self._thread = threading.Thread(target=self._run, name='replay', daemon=True)
        self._thread.start()

    def _open(self) -> Recording:
        value = self._value
        if not value('recording'):
            raise RecordingError('parameter recording is empty', expected='a path')
        recording = open_recording(
            value('recording'),
            sample_rate_hz=value('sample_rate_hz') or None,
            unit=value('unit') or None,
            channels=[name for name in value('channels') if name] or None,
            topics=[topic for topic in value('topics') if topic] or None,
        )
        layout = layout_from_file(Path(value('layout_file'))) if value('layout_file') else None
        return as_on_arm(recording, [name for name in value('joint_names') if name], layout)

    def _make_playback(self) -> Playback:
        values = parameter_mapping(self, PARAMETERS)
        settings = PlaybackSettings(
            remap=parse_remap(values['remap']), **from_parameters(PlaybackSettings, values)
        )
        return Playback(self.recording, settings)

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    # -- playing -------------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._announce()
            self._play()
            self._wait_until_heard()
        except ModalAnalysisError as error:
            self.failure = str(error)
        except RCLError as error:
            self.failure = '' if self._closing.is_set() or not self.context.ok() else str(error)
        finally:
            self.done.set()

    def _announce(self) -> None:
        """Make the publishers and wait until somebody listens, so that nothing is missed."""
        remap = self.playback.settings.remap or {}
        entries = getattr(self.recording, 'entries', ())
        selected: frozenset[str] = getattr(self.recording, 'selected', frozenset())
        for entry in entries:
            if entry.name in selected:
                self._output(remap.get(entry.name, entry.name), entry.message_type)
        if not self._outputs:
            # Of columns: each stretch of responses, and its joint states behind it.
            n_topics = 1 + _has_joints(self.recording)
            for message in Playback(self.recording, self.playback.settings).messages():
                self._output(message.topic, message.message_type)
                if len(self._outputs) == n_topics:
                    break
        deadline = time.monotonic() + self._value('wait_for_subscribers_s')
        while time.monotonic() < deadline and not self._closing.wait(0.05):
            if all(output.get_subscription_count() for output in self._outputs.values()):
                break
        self._closing.wait(0.2)

    def _wait_until_heard(self) -> None:
        """Stay until a busy listener has the last message too."""
        deadline = time.monotonic() + LAST_WORDS_S
        for output in self._outputs.values():
            while not output.wait_for_all_acked(Duration(seconds=0.1)):
                if self._closing.is_set() or time.monotonic() > deadline:
                    return

    def _play(self) -> None:
        began_s, clock_s = time.monotonic(), -1.0
        for message in self.playback.messages():
            began_s = self._wait_until_due(message.due_s, began_s)
            if self._closing.is_set():
                return
            lateness_s = time.monotonic() - began_s - message.due_s
            self.largest_lateness_s = max(self.largest_lateness_s, lateness_s)
            if self.clock_publisher is not None and message.due_s >= clock_s:
                clock_s = message.due_s + CLOCK_PERIOD_S
                self.clock_publisher.publish(Clock(clock=stamp(message.recorded_ns)))
            self._publish(message)

    def _publish(self, message: DueMessage) -> None:
        self._output(message.topic, message.message_type).publish(message.data)
        self.n_published += 1
        self._first_ns = message.recorded_ns if self._first_ns is None else self._first_ns
        self._now_ns = message.recorded_ns

    def _output(self, topic: str, message_type: str) -> Publisher:
        if topic not in self._outputs:
            package, _, name = message_type.partition('/msg/')
            try:
                kind = getattr(importlib.import_module(f'{package}.msg'), name)
            except (ImportError, AttributeError) as error:
                raise RecordingError(
                    'message type is not installed', where=topic, found=message_type
                ) from error
            self._outputs[topic] = self.create_publisher(kind, topic, RELIABLE)
        return self._outputs[topic]

    def _wait_until_due(self, due_s: float, began_s: float) -> float:
        """Wait for a message's time or for a step; return when playback began, pauses left out."""
        while not self._closing.is_set():
            now_s = time.monotonic()
            with self._gate:
                if self._steps:
                    self._steps -= 1
                    return now_s - due_s
                paused = self._paused
                if paused:
                    self._gate.wait(CLOCK_PERIOD_S)
            if paused:
                began_s += time.monotonic() - now_s
                continue
            wait_s = began_s + due_s - now_s
            if wait_s <= 0.0:
                break
            self._closing.wait(min(wait_s, CLOCK_PERIOD_S))
        return began_s

    # -- services ------------------------------------------------------------------------------

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        with self._gate:
            self._paused, self._steps = request.data, 0
            self._gate.notify_all()
        response.success, response.message = True, 'paused' if request.data else 'playing'
        return response

    def _on_step(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self._gate:
            response.success = self._paused
            response.message = 'one message' if self._paused else 'not paused'
            self._steps += int(self._paused)
            self._gate.notify_all()
        return response

    def _publish_state(self) -> None:
        state = FlowState.RUNNING
        if self.done.is_set():
            state = FlowState.ABORTED if self.failure else FlowState.HOLDING
        elif self._paused:
            state = FlowState.IDLE
        message = BridgeState(
            backend='replay',
            state=int(state),
            reason=self.failure or ('paused' if self._paused else ''),
            n_sent=self.n_published,
            connected=True,
        )
        message.header.stamp = self.get_clock().now().to_msg()
        with contextlib.suppress(RCLError):
            self.states.publish(message)

    def destroy_node(self) -> None:
        """Stop playing, then the node."""
        self._closing.set()
        with self._gate:
            self._gate.notify_all()
        self._thread.join(timeout=2.0)
        super().destroy_node()


def _has_joints(recording: Recording) -> bool:
    return isinstance(recording, ArrayRecording) and recording.read_from.joints is not None


def _spin(node: ReplayNode) -> None:
    """Play until the end or until stopped."""
    stay = not node.get_parameter('exit_at_end').value
    while rclpy.ok() and (stay or not node.done.is_set()):
        rclpy.spin_once(node, timeout_sec=0.1)
    node._publish_state()
    if node.failure:
        raise RecordingError(node.failure)
    node.get_logger().info(
        f'{node.n_published} messages played, latest {1e3 * node.largest_lateness_s:.0f} ms'
    )


def main(args: Sequence[str] | None = None) -> None:
    """Play until the end or until stopped; exit status 2 when the recording cannot be played."""
    run_node('replay', ReplayNode, _spin, args)


if __name__ == '__main__':
    main()
