"""What an operator may ask of the bridge, as services: arm, start, abort, reset, heartbeat."""

from collections.abc import Callable
import contextlib
import time
from typing import Any

from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from rclpy.clock import Clock
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from modal_core.errors import BridgeError, ModalAnalysisError
from modal_core.nodes.polled_group_node import PolledGroup
from modal_core.nodes.ros_messages import heard_s
from modal_core.nodes.run_node import InvalidHandleError, RCLError
from oma_msgs.msg import Heartbeat
from oma_msgs.srv import ArmPlan, StartPlan
from robot_bridge.bridge import Bridge

# Deep enough for two senders of one token to be told apart.
HEARTBEAT = QoSProfile(depth=32, reliability=ReliabilityPolicy.BEST_EFFORT)
HEAR_S = 0.05


def no_callback(_: Heartbeat) -> None:
    """Do nothing: beats are taken, not delivered."""


class OperatorDesk:
    """The services of one node.

    Parameters
    ----------
    node : LifecycleNode
        Whose services.
    bridge : callable
        Returns the bridge, None while it is not configured.
    look : callable
        Called before what may release a motion: who else has these names, as of now?
    answered : callable
        Called after every request that may have changed the state.
    quick : CallbackGroup
        Group of what must not wait for anything.
    steady : Clock
        Time of this machine.
    """

    def __init__(
        self,
        node: LifecycleNode,
        bridge: Callable[[], Bridge | None],
        look: Callable[[], None],
        answered: Callable[[], None],
        quick: CallbackGroup,
        steady: Clock,
    ) -> None:
        self._node, self._bridge = node, bridge
        self._look, self._answered = look, answered
        slow, abort = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
        # A beat must wait for no other work of this process: whoever is about to call the
        # operator silent looks itself.  The timer is for when nobody is.
        self._beats = node.create_subscription(
            Heartbeat, '~/heartbeat', no_callback, HEARTBEAT, callback_group=PolledGroup()
        )
        node.create_timer(HEAR_S, self._listen, callback_group=quick, clock=steady)
        node.create_service(ArmPlan, '~/arm', self._on_arm, callback_group=slow)
        node.create_service(StartPlan, '~/start', self._on_start, callback_group=slow)
        for name, action, group in (
            ('reset', self._reset, slow),
            # Not behind a start that waits for the controller's web services.
            ('abort', lambda found: found.backend.abort('aborted by the operator'), abort),
        ):
            node.create_service(
                Trigger, f'~/{name}', self._trigger(name, action), callback_group=group
            )

    def hear(self) -> None:
        """Take the beats that have come, each for when it came; the flow calls it."""
        bridge = self._bridge()
        if bridge is None:
            return
        with contextlib.suppress(RCLError, InvalidHandleError), self._beats.handle:
            while taken := self._beats.handle.take_message(Heartbeat, False):
                beat, info = taken
                number = info['publication_sequence_number']
                bridge.flow.heartbeat(heard_s(info), beat.token, number)

    def _listen(self) -> None:
        bridge = self._bridge()
        if bridge is not None:
            bridge.flow.listen()

    def _on_arm(self, request: ArmPlan.Request, response: ArmPlan.Response) -> ArmPlan.Response:
        try:
            self._look()
            bridge, now_s = self._configured(), time.monotonic()
            response.token = bridge.release(
                request.plan_hash, request.controller, request.timeout_s, now_s
            )
            response.accepted, response.message = True, bridge.flow.reason
        except ModalAnalysisError as error:
            response.message = str(error)
            self._node.get_logger().warning(f'arm: {error}')
        return response

    def _on_start(
        self, request: StartPlan.Request, response: StartPlan.Response
    ) -> StartPlan.Response:
        def start(bridge: Bridge) -> None:
            self._look()
            bridge.backend.start(time.monotonic(), request.token)

        return self._answer('start', start, response)

    def _reset(self, bridge: Bridge) -> None:
        self._look()
        bridge.flow.reset()

    def _trigger(self, name: str, action: Callable[[Bridge], None]) -> Any:
        return lambda _, response: self._answer(name, action, response)

    def _answer(self, name: str, action: Callable[[Bridge], None], response: Any) -> Any:
        try:
            bridge = self._configured()
            action(bridge)
            response.success, response.message = True, bridge.flow.reason
        except ModalAnalysisError as error:
            response.message = str(error)
            self._node.get_logger().warning(f'{name}: {error}')
        self._answered()
        return response

    def _configured(self) -> Bridge:
        bridge = self._bridge()
        if bridge is None:
            raise BridgeError('the bridge is not configured', advice='configure it first')
        return bridge
