"""The operator as a ROS node: releases a plan, holds to run, and watches what comes of it."""

from collections.abc import Callable
import threading
import time
from typing import Any, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from modal_core.errors import BridgeError
from modal_core.nodes.ros_messages import LATCHED
from oma_msgs.msg import BridgeState, ExcitationPlan, Heartbeat, ModalParameters
from oma_msgs.srv import ArmPlan, StartPlan

RESULTS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
HEARTBEAT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
HEARTBEAT_PERIOD_S = 0.02
POLL_S = 0.05
RELEASE_S = 30.0
REFUSED = 'PLAN_REFUSED'
"""What the diagnostics of planner and bridge begin with where they refuse a plan."""
PLANNING = ('excitation_planner', 'robot_bridge')
Value = TypeVar('Value')


def no_check() -> None:
    """Let everything pass."""


class OperatorNode(Node):
    """What a person at the cell does: for the demo, for campaigns, for `ama operate`.

    Spin it in an executor of its own; its methods wait for the others and may be called from
    another thread only.

    Attributes
    ----------
    state_s : float [s]
        When the bridge's state was heard last, monotonic clock.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__('ama_operator', **options)
        self.plan: ExcitationPlan | None = None
        self.state: BridgeState | None = None
        self.state_s = 0.0
        self.windows: list[ModalParameters] = []
        self._refusals: dict[str, str] = {}
        self.create_subscription(
            ExcitationPlan, 'excitation_planner/excitation_plan', self._on('plan'), LATCHED
        )
        self.create_subscription(BridgeState, 'robot_bridge/state', self._on_state, LATCHED)
        self.create_subscription(
            ModalParameters, 'oma_identifier/modal_parameters', self.windows.append, RESULTS
        )
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        self._arm = self.create_client(ArmPlan, 'robot_bridge/arm')
        self._start = self.create_client(StartPlan, 'robot_bridge/start')
        self._triggers = {
            name: self.create_client(Trigger, name)
            for name in ('robot_bridge/abort', 'robot_bridge/reset')
        }
        self._heartbeat = self.create_publisher(Heartbeat, 'robot_bridge/heartbeat', HEARTBEAT)
        self._token = ''
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None

    def wait_for(
        self,
        what: str,
        value: Callable[[], Value | None],
        timeout_s: float,
        check: Callable[[], None] = no_check,
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

    def release(
        self,
        plan_hash: str,
        controller: str,
        timeout_s: float,
        check: Callable[[], None] = no_check,
    ) -> str:
        """Release the plan with this hash for this controller; return the token.

        Raises
        ------
        BridgeError
            The bridge refuses, with its reason.
        """
        request = ArmPlan.Request(plan_hash=plan_hash, controller=controller, timeout_s=RELEASE_S)
        answer = self.ask(self._arm, request, timeout_s, check)
        if not answer.accepted:
            raise BridgeError(f'the plan was not released: {answer.message}')
        return str(answer.token)

    def start_later(self, token: str) -> Any:
        """Ask to play the released plan; return the future answer."""
        return self._start.call_async(StartPlan.Request(token=token))

    def abort_later(self) -> Any:
        """Ask to stop; return the future answer."""
        return self._triggers['robot_bridge/abort'].call_async(Trigger.Request())

    def trigger(self, name: str, timeout_s: float) -> str:
        """Ask something of a node, such as ``robot_bridge/reset``; return what it answers.

        Raises
        ------
        BridgeError
            It refuses, with its reason, or nobody answers.
        """
        if name not in self._triggers:
            self._triggers[name] = self.create_client(Trigger, name)
        answer = self.ask(self._triggers[name], Trigger.Request(), timeout_s)
        if not answer.success:
            raise BridgeError(f'{name} refused: {answer.message}')
        return str(answer.message)

    def run(
        self, plan_hash: str, controller: str, timeout_s: float, check: Callable[[], None]
    ) -> None:
        """Release the plan with this hash for this controller, hold to run, and start it.

        Raises
        ------
        BridgeError
            The bridge refuses, with its reason.
        """
        self._token = self.release(plan_hash, controller, timeout_s, check)
        if self._thread is None:
            self._thread = threading.Thread(target=self._beat, name='heartbeat', daemon=True)
            self._thread.start()
        time.sleep(5 * HEARTBEAT_PERIOD_S)
        request = StartPlan.Request(token=self._token)
        started = self.ask(self._start, request, timeout_s, check)
        if not started.success:
            raise BridgeError(f'the plan was not started: {started.message}')

    def check_planned(self) -> None:
        """Raise when the planner made no plan, or the bridge takes none.

        Raises
        ------
        BridgeError
            With the reason.
        """
        for node, reason in self._refusals.items():
            if reason:
                raise BridgeError(f'{node}: {reason}')

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
        if self._thread is not None:
            self._thread.join(timeout=1.0)

    def ask(
        self, client: Any, request: Any, timeout_s: float, check: Callable[[], None] = no_check
    ) -> Any:
        """Return the answer of a service, once it is there.

        Raises
        ------
        BridgeError
            Nobody answers.
        """
        self.wait_for(client.srv_name, client.service_is_ready, timeout_s, check)
        future = client.call_async(request)
        self.wait_for(f'answer of {client.srv_name}', future.done, timeout_s, check)
        return future.result()

    def _beat(self) -> None:
        while not self._closing.wait(HEARTBEAT_PERIOD_S):
            if token := self._token:
                self._heartbeat.publish(Heartbeat(token=token))

    def _on_state(self, state: BridgeState) -> None:
        self.state, self.state_s = state, time.monotonic()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        own = self.get_namespace().rstrip('/')
        for status in message.status:
            node, _, _ = status.name.removeprefix(f'{own}/').partition(':')
            if node in PLANNING:
                _, refused, reason = status.message.partition(REFUSED)
                self._refusals[node] = reason.strip() if refused else ''

    def _on(self, name: str) -> Callable[[Any], None]:
        return lambda message: setattr(self, name, message)

    def _situation(self) -> str:
        return f'bridge: {self.state.reason}' if self.state is not None else 'no bridge'
