"""Listens to planner and bridge for where the excitation that is being played ends."""

from collections.abc import Callable

from rclpy.node import Node

from modal_core.nodes.ros_messages import LATCHED
from oma_identifier.covariance import sharp_edge_hz
from oma_msgs.msg import BridgeState, ExcitationPlan

MOST_PLANS = 16


class ExcitationWatch:
    """Tells when the edge of the excitation changes: a plan is played, or no longer.

    A plan that merely lies ready tells nothing about the motion that is measured.

    Parameters
    ----------
    node : Node
        Gets the subscriptions.
    plan_topic, bridge_topic : str
        Of the planner's ExcitationPlan and the bridge's BridgeState.
    on_change : callable
        Takes the upper edge [Hz], None without one.

    Attributes
    ----------
    robot_name : str
        Robot of the plan that came last; empty before.
    """

    def __init__(
        self,
        node: Node,
        plan_topic: str,
        bridge_topic: str,
        on_change: Callable[[float | None], None],
    ) -> None:
        self.edge_hz: float | None = None
        self.robot_name = ''
        self._on_change = on_change
        self._edges_hz: dict[str, float | None] = {}
        self._playing = ''
        node.create_subscription(ExcitationPlan, plan_topic, self._take_plan, LATCHED)
        node.create_subscription(BridgeState, bridge_topic, self._take_state, LATCHED)

    def _take_plan(self, plan: ExcitationPlan) -> None:
        self.robot_name = plan.robot_name
        # The planner may plan the next motion while the last one is still played.
        self._edges_hz[plan.plan_hash] = sharp_edge_hz(plan.signal, plan.band_high_hz)
        while len(self._edges_hz) > MOST_PLANS:
            del self._edges_hz[next(iter(self._edges_hz))]
        self._compare()

    def _take_state(self, state: BridgeState) -> None:
        moving = state.state == BridgeState.RUNNING and not state.dry_run
        self._playing = state.plan_hash if moving else ''
        self._compare()

    def _compare(self) -> None:
        edge_hz = self._edges_hz.get(self._playing)
        if edge_hz != self.edge_hz:
            self.edge_hz = edge_hz
            self._on_change(edge_hz)
