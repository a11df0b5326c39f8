"""Serves the live page: listens to a cell, tells browsers, moves nothing."""

from collections.abc import Sequence
import secrets
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from modal_core.errors import SettingsError
from modal_core.nodes.ros_messages import declare_parameters, diagnostic, LATCHED, RESULTS
from modal_core.nodes.run_node import run_node
from modal_dashboard.digest import Digest
from modal_dashboard.drawn_arm import DrawnArm
from modal_dashboard.node_parameters import PARAMETERS
from modal_dashboard.ros_messages import bridge_news, check, diagram, plan_news
from modal_dashboard.screens import Check
from modal_dashboard.server import Access, host_of, is_loopback, PageServer, SHORTEST_TOKEN
from modal_history.ros_messages import kept_window
from oma_msgs.msg import BridgeState, ExcitationPlan, ModalParameters, StabilisationDiagram

DIAGNOSTICS_DEPTH = 100
STATE_PERIOD_S = 0.2
"""A bridge tells its state more often than anybody reads it."""
DIAGNOSTICS_PERIOD_S = 1.0


class DashboardNode(Node):
    """Hands messages over to the digest, which tells the browsers."""

    def __init__(self, **options: Any) -> None:
        super().__init__('modal_dashboard', **options)
        declare_parameters(self, PARAMETERS)
        address = self._value('address')
        token = self._token(address)
        names = self.get_parameter_or('host_names').value or ()
        self.server = PageServer(address, self._value('port'), Access(token, tuple(names)))
        self.url = (
            f'http://{host_of(address)}:{self.server.port}/{f"?token={token}" if token else ""}'
        )
        self.arm = DrawnArm(self._value('robot'))
        self.digest = Digest(self.server.send, self.arm, self.get_namespace())
        self._bridge: BridgeState | None = None
        self._told: dict[str, DiagnosticStatus] = {}
        self._listen()
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.create_timer(STATE_PERIOD_S, self._pass_on)
        self.create_timer(DIAGNOSTICS_PERIOD_S, self._publish_diagnostics)
        self.get_logger().info(f'the page is at {self.url}')

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _token(self, address: str) -> str:
        token: str = self._value('token')
        if token and len(token) < SHORTEST_TOKEN:
            raise SettingsError(
                'token too short',
                where='token',
                found=f'{len(token)} letters',
                expected=f'{SHORTEST_TOKEN} or more',
            )
        return token or ('' if is_loopback(address) else secrets.token_urlsafe(24))

    def _listen(self) -> None:
        take = self.digest
        names = {name: self._value(name) for name in ('identifier', 'planner', 'bridge')}
        for message_type, topic, then, read in (
            (ModalParameters, f'{names["identifier"]}/modal_parameters', take.window, kept_window),
            (
                StabilisationDiagram,
                f'{names["identifier"]}/stabilisation_diagram',
                take.diagram,
                diagram,
            ),
            (ExcitationPlan, f'{names["planner"]}/excitation_plan', take.plan, plan_news),
        ):
            self.create_subscription(
                message_type,
                topic,
                lambda message, then=then, read=read: take.hand(then, read, message),
                RESULTS,
            )
        self.create_subscription(
            BridgeState, f'{names["bridge"]}/state', self._take_bridge, LATCHED
        )
        self.create_subscription(
            DiagnosticArray, '/diagnostics', self._take_checks, DIAGNOSTICS_DEPTH
        )

    # -- what is told often goes on five times a second --------------------------------------

    def _take_bridge(self, message: BridgeState) -> None:
        self._bridge = message

    def _take_checks(self, message: DiagnosticArray) -> None:
        if len(self._told) < DIAGNOSTICS_DEPTH:
            told = message.status[:DIAGNOSTICS_DEPTH]
            self._told.update({status.name: status for status in told})

    def _pass_on(self) -> None:
        bridge, self._bridge = self._bridge, None
        if bridge is not None:
            self.digest.hand(self.digest.bridge, bridge_news, bridge)
        told, self._told = self._told, {}
        if told:
            self.digest.hand(self.digest.checks, _checks, list(told.values()))

    # -- output ----------------------------------------------------------------------------

    def findings(self) -> list[tuple[str, str]]:
        """Return code and text of what is wrong."""
        found = []
        if self.digest.n_refused:
            found.append(('MESSAGE_REFUSED', f'{self.digest.n_refused} could not be shown'))
        if self.arm.problem:
            found.append(('ROBOT_NOT_DRAWN', self.arm.problem))
        if self.digest.n_skipped:
            found.append(('MESSAGE_SKIPPED', f'{self.digest.n_skipped} came too fast'))
        return found

    def _publish_diagnostics(self) -> None:
        found, own = self.findings(), self.get_fully_qualified_name()
        # Without the token: whoever reads diagnostics need not see the page.
        values = {**dict(found), 'page': self.url.partition('?')[0]}
        values |= {'windows': str(self.digest.n_windows)}
        values |= {'browsers': str(self.server.n_viewers), 'let go': str(self.server.n_slow)}
        level = DiagnosticStatus.WARN if found else DiagnosticStatus.OK
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        code = found[0][0] if found else 'OK'
        message.status = [diagnostic(f'{own}: page', code, level, values, own)]
        self._diagnostics.publish(message)

    def destroy_node(self) -> None:
        """Stop the digest, then the server, then the node."""
        self.digest.close()
        self.server.close()
        super().destroy_node()


def _checks(told: Sequence[DiagnosticStatus]) -> list[Check]:
    return [check(status) for status in told]


def main(args: Sequence[str] | None = None) -> None:
    """Run the node until it is told to stop."""
    run_node('modal_dashboard', DashboardNode, args=args)


if __name__ == '__main__':
    main()
