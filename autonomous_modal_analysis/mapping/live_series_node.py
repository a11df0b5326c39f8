"""A released series played at the bridge: a person holds to run, each motion is armed by its hash.

Nothing here moves without a hold: every motion is armed for its own hash and one controller, and
beats only while the key or button is held.  What is not of the series, as the way to a pose from
where an arm was stopped, is shown and asks for a release of its own.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
import threading
import time
from typing import Any

from autonomous_modal_analysis.live.live_player_node import (
    HELD_S,
    LivePlayer,
    POLL_S,
    REST_S,
    TAKEN_S,
)
from autonomous_modal_analysis.live.operator_node import OperatorNode
from autonomous_modal_analysis.live.recorder_node import RecorderNode
from autonomous_modal_analysis.live.spinning_node import ros_context, spinning
from autonomous_modal_analysis.mapping.series import plan_way, Series
from autonomous_modal_analysis.mapping.series_release import SeriesRelease
from autonomous_modal_analysis.operating.beat_process import BeatProcess
from autonomous_modal_analysis.operating.cell_node import ANSWER_S, CellView
from autonomous_modal_analysis.operating.holding import (
    ButtonHolding,
    Holding,
    kept,
    space_bar,
)
from autonomous_modal_analysis.operating.panel import Panel
from autonomous_modal_analysis.operating.sides import Person
from autonomous_modal_analysis.operating.situation import Act
from excitation_planner.node.latest_joints_node import LatestJoints
from excitation_planner.plan import ExcitationPlan
from excitation_planner.request import PlanRequest
from excitation_planner.ways import is_there
from modal_core.channel import SensorLayout
from modal_core.errors import BridgeError, ModalAnalysisError
from modal_core.work.progress import Progress
from oma_msgs.msg import BridgeState
from oma_msgs.msg import ExcitationPlan as PlanMessage
from structural_model.flexible_joint_model import FlexibleJointModel

MOVES = (BridgeState.ARMED, BridgeState.RUNNING, BridgeState.STOPPING)
ENDED_S = 60.0
"""For a recording to be closed after its motion, on a busy machine."""


class SeriesCell(CellView):
    """The cell as the panel sees it, with motions of a series in hand instead of the planner's.

    Parameters
    ----------
    node : OperatorNode
        Spinning.
    beats : BeatProcess
        Running.
    player : LivePlayer
        Spinning; publishes plans.
    model : FlexibleJointModel
        The robot.
    request : PlanRequest
        What the motions were planned for: box and clearance hold for ways too.
    """

    def __init__(
        self,
        node: OperatorNode,
        beats: BeatProcess,
        player: LivePlayer,
        model: FlexibleJointModel,
        request: PlanRequest,
    ) -> None:
        super().__init__(node, beats)
        self._player, self._model, self._request = player, model, request
        self._joints = LatestJoints(player, model.joint_names)
        self._goal: ExcitationPlan | None = None
        self._hand: ExcitationPlan | None = None
        self.released: SeriesRelease | None = None

    def release(self, plan_hash: str, controller: str) -> str:
        """Release a motion, for the controller of the series alone; return the token.

        Raises
        ------
        BridgeError
            Another controller, or the bridge refuses.
        """
        if self.released is not None:
            self.released.check_controller(controller)
        return super().release(plan_hash, controller)

    def offer(self, plan: ExcitationPlan) -> None:
        """Put a motion into the hands of the bridge.

        Raises
        ------
        BridgeError
            It does not take it.
        """
        self._goal = plan
        self._put(plan)

    def plan(self) -> ExcitationPlan | None:
        """Return the motion in hand."""
        return self._hand

    def is_at(self, plan: ExcitationPlan) -> bool:
        """Tell whether the arm stands where a motion starts.

        Raises
        ------
        PlanError
            Nobody tells where it stands.
        """
        return is_there(self._joints.position(), plan)

    def help(self, act: Act) -> str:
        """Do what a step asks for; the way to a start is planned from where the arm stands.

        Raises
        ------
        BridgeError
            It is refused.
        """
        if act is not Act.WAY_BACK or self._goal is None:
            return super().help(act)
        try:
            here = self._joints.position()
            if not is_there(here, self._goal):
                to = self._goal
                way = plan_way(
                    self._model, self._request, here, to.start_position, to.sample_period_s
                )
                return self._put(way)
        except ModalAnalysisError as error:
            raise BridgeError(f'no way to the start: {error}') from error
        return self._put(self._goal)

    def _put(self, plan: ExcitationPlan) -> str:
        self._hand = plan
        self._player.publish(plan)
        node = self.node
        node.wait_for(
            'plan at the bridge',
            lambda: node.state is not None and node.state.plan_hash == plan.plan_hash,
            max(TAKEN_S, ANSWER_S),
        )
        return plan.plan_hash


class LiveSeries:
    """Plays the motions of a released series, and records.

    Parameters
    ----------
    cell : SeriesCell
        Where.
    player : LivePlayer
        Knows the sensors.
    person : Person
        Who holds.
    holding : callable
        Returns, as a context manager, what is held to run.
    release : callable
        Takes the controller's name; returns what was released.
    """

    def __init__(
        self,
        cell: SeriesCell,
        player: LivePlayer,
        person: Person,
        holding: Callable[[], AbstractContextManager[Holding]],
        release: Callable[[str], SeriesRelease],
    ) -> None:
        self._cell, self._player, self._person = cell, player, person
        self._holding, self._make_release = holding, release

    def travel(self, way: ExcitationPlan) -> None:
        """Move to the next pose, where the arm stands at the beginning of the way.

        Elsewhere the way from there is planned with the excitation, and asks for its own release.
        """
        if self._cell.is_at(way):
            self._lead(way)

    def play(self, plan: ExcitationPlan, path: Path, progress: Progress) -> None:
        """Play an excitation and leave its recording.

        Raises
        ------
        BridgeError
            The person left, or what is recorded cannot be kept.
        """
        topics, left = self._player.sensors(), threading.Event()
        with ThreadPoolExecutor(1) as pool:
            recording = pool.submit(self._record, plan, path, topics, left)
            try:
                self._lead(plan)
                recording.result(ENDED_S)
            finally:
                left.set()
        progress(1.0)

    def _lead(self, plan: ExcitationPlan) -> None:
        self._cell.offer(plan)
        situation = self._cell.situation()
        if situation is None or situation.dry_run:
            raise BridgeError('the bridge runs dry', advice='start it with dry_run:=false')
        if self._cell.released is None:
            self._cell.released = self._make_release(situation.controller)
        released = self._cell.released
        chosen = released.chosen(plan.plan_hash, situation.controller, time.monotonic())
        Panel(self._cell, self._person, self._holding, chosen, windows_s=0.0).run()

    def _record(
        self, plan: ExcitationPlan, path: Path, topics: dict[str, type[Any]], left: threading.Event
    ) -> None:
        """Record attempts until one came to its end, or nobody waits any more."""
        latched = self._player.plan_topic
        while not left.is_set():
            recorder = RecorderNode(
                path,
                {**topics, latched: PlanMessage},
                (latched,),
                held_s=HELD_S,
                attached=self._player.attached,
                context=self._player.context,
            )
            recorder.keep = False
            with spinning(recorder):
                if self._wait(plan, MOVES, left):
                    recorder.begin()
                    while self._is_in(plan, MOVES) and not left.is_set():
                        time.sleep(POLL_S)
                    recorder.keep = self._is_in(plan, (BridgeState.HOLDING,))
                    if recorder.keep:
                        time.sleep(REST_S)
            if recorder.failure:
                raise BridgeError(recorder.failure)
            if recorder.keep:
                return

    def _is_in(self, plan: ExcitationPlan, states: tuple[int, ...]) -> bool:
        state = self._cell.node.state
        return state is not None and state.plan_hash == plan.plan_hash and state.state in states

    def _wait(self, plan: ExcitationPlan, states: tuple[int, ...], left: threading.Event) -> bool:
        while not left.is_set():
            if self._is_in(plan, states):
                return True
            time.sleep(POLL_S)
        return False


@dataclass(frozen=True, slots=True)
class Deadman:
    """What is held to run.

    Parameters
    ----------
    joy_topic : str
        Of a joystick; empty: the space bar of this terminal.
    button : int
        Its button.
    """

    joy_topic: str = ''
    button: int = 4


@contextmanager
def live_series(
    model: FlexibleJointModel,
    request: PlanRequest,
    series: Series,
    person: Person,
    deadman: Deadman,
    namespace: str = '',
    layout: SensorLayout | None = None,
) -> Iterator[LiveSeries]:
    """Yield who plays a released series, in the cell of a namespace in this shell's domain."""
    name = namespace.strip('/')
    with (
        ros_context() as context,
        spinning(OperatorNode(context=context, namespace=name)) as node,
        spinning(
            LivePlayer(model, person.tell, layout, context=context, namespace=name)
        ) as player,
        BeatProcess(name) as beats,
    ):
        cell = SeriesCell(node, beats, player, model, request)
        holding: Callable[[], AbstractContextManager[Holding]] = space_bar
        if deadman.joy_topic:
            look = cell.button(deadman.joy_topic, deadman.button)
            holding = kept(ButtonHolding(look, deadman.button))
        yield LiveSeries(
            cell,
            player,
            person,
            holding,
            lambda controller: SeriesRelease.of(series, controller, time.monotonic()),
        )
