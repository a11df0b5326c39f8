"""The heartbeat as a process of its own: nothing else runs in it that could hold a beat up.

On standard input come lines ``TOKEN UNTIL``, until when [s] (the system's monotonic clock) the
operator who has this token is known to hold; on standard output go lines of figures.  When no
line comes any more, or the other side is gone, the beats end by themselves.
"""

from collections.abc import Sequence
import contextlib
import gc
import os
import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from autonomous_modal_analysis.operating.beats import BeatReport, Beats, PERIOD_S
from modal_core.work.real_time import ask_for_real_time
from oma_msgs.msg import Heartbeat

HEARTBEAT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
PRIORITY = 10
# As often as the bridge tells its state.
REPORT_S = 0.1
MOST_BYTES = 65536


class BeatNode(Node):
    """Publishes beats while they are due."""

    def __init__(self) -> None:
        super().__init__('ama_operator_beat', enable_rosout=False, start_parameter_services=False)
        self._publisher = self.create_publisher(Heartbeat, 'robot_bridge/heartbeat', HEARTBEAT)
        self.beats = Beats()

    def run(self) -> None:
        """Beat until standard input ends."""
        report_s = due_s = time.monotonic()
        while self._heard():
            now_s = time.monotonic()
            if token := self.beats.due(now_s):
                self._publisher.publish(Heartbeat(token=token))
            if now_s >= report_s:
                self._say(self.beats.report(self._publisher.get_subscription_count()))
                report_s = now_s + REPORT_S
            # Not sooner than due: beats that were missed are not made up for.
            due_s = max(due_s + PERIOD_S, now_s)
            time.sleep(max(due_s - time.monotonic(), 0.0))

    def _heard(self) -> bool:
        """Take what came on standard input; return False at its end."""
        with contextlib.suppress(BlockingIOError):
            while data := os.read(sys.stdin.fileno(), MOST_BYTES):
                self.beats.hear(data.decode())
            return False
        return True

    def _say(self, report: BeatReport) -> None:
        with contextlib.suppress(BlockingIOError):
            os.write(sys.stdout.fileno(), f'{report.line()}\n'.encode())


def main(args: Sequence[str] | None = None) -> None:
    """Beat as told until the other side is gone."""
    os.set_blocking(sys.stdin.fileno(), False)
    os.set_blocking(sys.stdout.fileno(), False)
    # Before the middleware's threads, so that they run as soon.
    ask_for_real_time(PRIORITY)
    rclpy.init(args=args, signal_handler_options=rclpy.SignalHandlerOptions.NO)
    node = BeatNode()
    gc.collect()
    gc.disable()
    with contextlib.suppress(KeyboardInterrupt, BrokenPipeError):
        node.run()
    # The beats have ended: there is nothing to take down in good order.
    os._exit(0)


if __name__ == '__main__':
    main()
