"""The cell as the panel sees it: through the operator's node, the beats and a button."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Joy

from autonomous_modal_analysis.live.operator_node import OperatorNode, RELEASE_S
from autonomous_modal_analysis.live.spinning_node import ros_context, spinning
from autonomous_modal_analysis.operating.beat_process import BeatProcess
from autonomous_modal_analysis.operating.beats import BeatReport
from autonomous_modal_analysis.operating.situation import Act, Situation
from autonomous_modal_analysis.views.message_view_node import window_line
from excitation_planner.plan import ExcitationPlan
from excitation_planner.ros_messages import plan_from_message
from modal_core.nodes.ros_messages import heard_s
from robot_bridge.operator import FlowState

# No longer than a release lasts: what is answered later would be of one that is over.
ANSWER_S = RELEASE_S
BUTTONS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
HELPS = {
    Act.RESET: ('robot_bridge/reset',),
    Act.MOTORS: ('abb_emulator/motors_on',),
    Act.PROGRAM: ('abb_emulator/reset_program', 'abb_emulator/start_program'),
    Act.WAY_BACK: ('excitation_planner/plan_way_back',),
}


class Button:
    """A deadman button of a joystick: its state with the time it was received."""

    def __init__(self, node: OperatorNode, topic: str, number: int) -> None:
        self._number = number
        self._signs: list[tuple[bool, float]] = []
        node.create_subscription(Joy, topic, self._take, BUTTONS)

    def look(self) -> Sequence[tuple[bool, float]]:
        """Return what came since the last look: pressed or not, and when [s]."""
        found, self._signs = self._signs, []
        return found

    def _take(self, message: Joy, info: dict[str, Any]) -> None:
        pressed = self._number < len(message.buttons) and bool(message.buttons[self._number])
        self._signs.append((pressed, heard_s(info)))


class CellView:
    """What the panel asks of a cell.

    Parameters
    ----------
    node : OperatorNode
        Spinning.
    beats : BeatProcess
        Running.
    """

    def __init__(self, node: OperatorNode, beats: BeatProcess) -> None:
        self.node, self.beats = node, beats
        self._n_windows = 0
        self._message: Any = None
        self._plan: ExcitationPlan | None = None

    def button(self, topic: str, number: int) -> Callable[[], Sequence[tuple[bool, float]]]:
        """Return what tells of a button of a joystick: pressed or not, and when [s]."""
        return Button(self.node, topic, number).look

    def situation(self) -> Situation | None:
        """Return what the bridge said last; None before."""
        state = self.node.state
        if state is None:
            return None
        return Situation(
            state=FlowState(state.state),
            reason=state.reason,
            backend=state.backend,
            controller=state.controller,
            dry_run=state.dry_run,
            connected=state.connected,
            motors_on=state.motors_on,
            controller_state=state.controller_state,
            plan_hash=state.plan_hash,
            progress=state.progress,
            heard_s=self.node.state_s,
        )

    def plan(self) -> ExcitationPlan | None:
        """Return the planner's plan, its hash recomputed; None before one came.

        Raises
        ------
        MessageError
            It is not what it says.
        """
        message = self.node.plan
        if message is not None and message is not self._message:
            self._plan, self._message = plan_from_message(message), message
        return self._plan

    def release(self, plan_hash: str, controller: str) -> str:
        """Release a plan; return the token.

        Raises
        ------
        BridgeError
            The bridge refuses.
        """
        return self.node.release(plan_hash, controller, ANSWER_S)

    def start_later(self, token: str) -> Callable[[], tuple[bool, str] | None]:
        """Ask to start; return a function that gives the answer once it is there."""
        future = self.node.start_later(token)

        def answer() -> tuple[bool, str] | None:
            if not future.done():
                return None
            found = future.result()
            return bool(found.success), str(found.message)

        return answer

    def abort(self) -> None:
        """Ask to stop, without waiting."""
        self.node.abort_later()

    def hold(self, token: str, until_s: float) -> None:
        """Beat with a token until a time [s].

        Raises
        ------
        BridgeError
            The heartbeat has ended by itself.
        """
        self.beats.hold(token, until_s)

    def let_go(self, token: str) -> None:
        """Beat no more."""
        self.beats.let_go(token)

    def report(self) -> BeatReport:
        """Return how the beats go."""
        return self.beats.report

    def help(self, act: Act) -> str:
        """Do what a step asks for, where a program can; return what was answered.

        Raises
        ------
        BridgeError
            It is refused.
        """
        found = '; '.join(filter(None, (self.node.trigger(n, ANSWER_S) for n in HELPS[act])))
        if act is Act.WAY_BACK:
            self.node.wait_for('way back in the hands of the bridge', self._has(found), ANSWER_S)
        return found

    def _has(self, plan_hash: str) -> Callable[[], bool]:
        """Return whether bridge and planner have this plan."""
        node = self.node
        return lambda: (
            node.state is not None
            and node.plan is not None
            and (node.state.plan_hash == node.plan.plan_hash == plan_hash)
        )

    def windows(self) -> Sequence[str]:
        """Return a line for each window identified since the last call."""
        found = self.node.windows[self._n_windows :]
        self._n_windows += len(found)
        return [window_line(message) for message in found]

    def check_beats(self) -> None:
        """Wait until the bridge can hear the beats.

        Raises
        ------
        BridgeError
            It does not.
        """

        def heard() -> bool:
            self.beats.check()
            return self.beats.report.n_listeners > 0

        self.node.wait_for('bridge that hears the heartbeat', heard, ANSWER_S)


@contextmanager
def cell_view(namespace: str) -> Iterator[CellView]:
    """Yield the view of the cell in a namespace, in the ROS domain of this shell."""
    name = namespace.strip('/')
    with (
        ros_context() as context,
        spinning(OperatorNode(context=context, namespace=name)) as node,
        BeatProcess(name) as beats,
    ):
        yield CellView(node, beats)
