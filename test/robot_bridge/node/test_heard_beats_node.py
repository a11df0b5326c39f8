"""Beats are heard by who is about to call the operator silent, whatever other threads do."""

import threading
import time

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = pytest.mark.node

BUSY_S, TIMEOUT_S = 2.0, 0.5


@pytest.fixture
def desk(drivers, domain):
    """Return a flow and its desk: a node that nobody spins, as if all its threads were busy."""
    from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
    from rclpy.clock import Clock, ClockType
    from rclpy.lifecycle import LifecycleNode

    from robot_bridge.node.operator_desk_node import OperatorDesk
    from robot_bridge.operator import FlowSettings, OperatorFlow

    class Bridge:
        flow = OperatorFlow(FlowSettings(heartbeat_timeout_s=TIMEOUT_S))

    context = drivers.context_of(domain)
    node = LifecycleNode('robot_bridge', context=context)
    desk = OperatorDesk(
        node,
        lambda: Bridge,
        lambda: None,
        lambda: None,
        MutuallyExclusiveCallbackGroup(),
        Clock(clock_type=ClockType.STEADY_TIME),
    )
    Bridge.flow.hear = desk.hear
    yield Bridge.flow
    node.destroy_node()
    context.try_shutdown()


def test_beats_are_heard_while_every_other_thread_of_the_bridge_is_busy(desk, operator):
    release = desk.release
    operator.token = release.grant(time.monotonic() + 60.0)
    operator.until(lambda: operator.beats.get_subscription_count() > 0, 'discovery')
    operator.hold()

    def heard():
        desk.listen()
        return not release.silent(time.monotonic(), TIMEOUT_S)

    operator.until(heard, 'beat')
    # Nobody has looked for a while; what came meanwhile is there.
    threading.Event().wait(BUSY_S)
    assert release.silent(time.monotonic(), TIMEOUT_S)
    assert heard()
    # And what waited is not taken for new.
    operator.hold(holding=False)
    threading.Event().wait(BUSY_S)
    assert not heard()
