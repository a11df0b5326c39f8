"""The operator as a ROS node: releases a plan, holds to run, and watches what comes of it."""

from collections.abc import Callable
import threading
import time
from typing import Any, TypeVar

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from modal_core.errors import BridgeError
from modal_core.ros_messages import LATCHED
from oma_msgs.msg import BridgeState, ExcitationPlan, Heartbeat, ModalParameters
from oma_msgs.srv import ArmPlan, StartPlan

RESULTS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
HEARTBEAT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
HEARTBEAT_PERIOD_S = 0.02
POLL_S = 0.05
RELEASE_S = 30.0
Value = TypeVar('Value')


class OperatorNode(Node):
    """What a person at the cell does, for the demo and for campaigns.

    Spin it in an executor of its own; its methods wait for the others and may be called from
    another thread only.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__('ama_operator', **options)
        self.plan: ExcitationPlan | None = None
        self.state: BridgeState | None = None
        self.truth: ModalParameters | None = None
        self.windows: list[ModalParameters] = []
        self.create_subscription(
            ExcitationPlan, 'excitation_planner/excitation_plan', self._on('plan'), LATCHED
        )
        self.create_subscription(BridgeState, 'robot_bridge/state', self._on('state'), LATCHED)
        self.create_subscription(
            ModalParameters, 'abb_emulator/true_modes', self._on('truth'), LATCHED
        )
        self.create_subscription(
            ModalParameters, 'oma_identifier/modal_parameters', self.windows.append, RESULTS
        )
        self._arm = self.create_client(ArmPlan, 'robot_bridge/arm')
        self._start = self.create_client(StartPlan, 'robot_bridge/start')
        self._heartbeat = self.create_publisher(Heartbeat, 'robot_bridge/heartbeat', HEARTBEAT)
        self._token = ''
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._beat, name='heartbeat', daemon=True)
        self._thread.start()

    def wait_for(
        self,
        what: str,
        value: Callable[[], Value | None],
        timeout_s: float,
        check: Callable[[], None],
    ) -> Value:
        """Wait until ``value`` gives something; ``check`` may raise meanwhile.

        Raises
        ------
        BridgeError
            Nothing came in time.
        """
        deadline = time.monotonic() + timeout_s
        while True:
            found = value()
            if found:
                return found
            check()
            if time.monotonic() > deadline:
                raise BridgeError(f'no {what} within {timeout_s:g} s', found=self._situation())
            time.sleep(POLL_S)

    def run(
        self, plan_hash: str, controller: str, timeout_s: float, check: Callable[[], None]
    ) -> None:
        """Release the plan with this hash for this controller, hold to run, and start it.

        Raises
        ------
        BridgeError
            The bridge refuses, with its reason.
        """
        self.wait_for('bridge', self._arm.service_is_ready, timeout_s, check)
        release = ArmPlan.Request(plan_hash=plan_hash, controller=controller, timeout_s=RELEASE_S)
        armed = self._call(self._arm, release, timeout_s, check)
        if not armed.accepted:
            raise BridgeError(f'the plan was not released: {armed.message}')
        self._token = armed.token
        time.sleep(5 * HEARTBEAT_PERIOD_S)
        request = StartPlan.Request(token=armed.token)
        started = self._call(self._start, request, timeout_s, check)
        if not started.success:
            raise BridgeError(f'the plan was not started: {started.message}')

    def check_running(self) -> None:
        """Raise when the bridge stopped the motion.

        Raises
        ------
        BridgeError
            With the bridge's reason.
        """
        state = self.state
        if state is not None and state.state == BridgeState.ABORTED:
            raise BridgeError('the bridge stopped the motion', found=state.reason)

    def close(self) -> None:
        """Let go of the heartbeat."""
        self._token = ''
        self._closing.set()
        self._thread.join(timeout=1.0)

    def _call(self, client: Any, request: Any, timeout_s: float, check: Callable[[], None]) -> Any:
        future = client.call_async(request)
        self.wait_for(f'answer of {client.srv_name}', future.done, timeout_s, check)
        return future.result()

    def _beat(self) -> None:
        while not self._closing.wait(HEARTBEAT_PERIOD_S):
            if token := self._token:
                self._heartbeat.publish(Heartbeat(token=token))

    def _on(self, name: str) -> Callable[[Any], None]:
        return lambda message: setattr(self, name, message)

    def _situation(self) -> str:
        return f'bridge: {self.state.reason}' if self.state is not None else 'no bridge'
