"""The way of one motion: look, preview, release by hash, hold to run, what came of it; no ROS."""

from collections.abc import Callable
from contextlib import AbstractContextManager
import time

from autonomous_modal_analysis.operating.held_run import HeldRun, LOOK_S, Outcome
from autonomous_modal_analysis.operating.holding import Holding
from autonomous_modal_analysis.operating.sides import Cell, Person
from autonomous_modal_analysis.operating.situation import Act, next_step, Step
from excitation_planner.plan import ExcitationPlan
from modal_core.errors import BridgeError
from modal_core.work.real_time import in_real_time

SHOW_S = 0.2
PRIORITY = 10
# Until the state after a stop has come: it is told ten times a second.
SETTLE_S = 0.3
SHORTEST_HASH = 8
LEAVE = 'q'
# Nobody to ask: a state that a person does not have to change gets so long to change by itself,
# which is what nodes get to start up.
LONGEST_WAIT_S = 60.0
# A controller that runs is heard by then; a program's stream begins with the program.
CONNECTED_S = 15.0
WINDOWS_S = 30.0


class LeftError(BridgeError):
    """The operator left; nothing moves."""


class Panel:
    """Leads a person through motions, one release each.

    Parameters
    ----------
    cell : Cell
        What is operated.
    person : Person
        Who operates.
    holding : callable
        Returns, as a context manager, what is held to run.
    chosen : str
        Beginning of the hash to release without asking; empty asks.
    windows_s : float [s]
        How long what was identified of the motion is waited for.
    """

    def __init__(
        self,
        cell: Cell,
        person: Person,
        holding: Callable[[], AbstractContextManager[Holding]],
        chosen: str = '',
        windows_s: float = WINDOWS_S,
    ) -> None:
        self._cell, self._person, self._holding = cell, person, holding
        self._chosen, self._windows_s = chosen, windows_s
        self._way_back = ''

    def run(self) -> None:
        """Lead through one motion to its end; again after each that was stopped.

        Raises
        ------
        LeftError
            The person left before.
        BridgeError
            No bridge or no plan came.
        """
        while True:
            self._until_ready()
            self._cell.check_beats()
            plan = self._previewed()
            try:
                self._confirm(plan)
                token = self._release(plan)
            except LeftError:
                raise
            except BridgeError as error:
                self._person.tell(f'{error}')
                self._pause('next: Enter looks again')
                continue
            outcome = self._hold_to_run(token)
            self._person.tell(outcome.words)
            if outcome.done and plan.plan_hash == self._way_back:
                # The arm is there: the same question gives the plan it went back for.
                self._plan_way_back()
                self._way_back = ''
            elif outcome.done:
                self._show_windows(self._windows_s)
                return

    # -- before --------------------------------------------------------------------------------

    def _until_ready(self) -> None:
        """Go on to where a plan can be released, with the person's word for every step."""
        while (step := self._settled()).act is not Act.RELEASE:
            self._person.tell(step.words)
            situation = self._cell.situation()
            emulated = situation is not None and situation.emulated
            if step.act is Act.WAY_BACK:
                self._pause('Enter plans it, which moves nothing')
                self._plan_way_back()
            elif step.act is Act.RESET or (emulated and step.act is not Act.WAIT):
                self._pause('Enter does it')
                self._help(step.act)
            else:
                self._pause('Enter looks again')

    def _plan_way_back(self) -> None:
        self._way_back = self._help(Act.WAY_BACK)

    def _help(self, act: Act) -> str:
        """Do what a step asks for; tell why not where it is refused."""
        try:
            return self._cell.help(act)
        except BridgeError as error:
            self._person.tell(f'{error}')
            return ''

    def _settled(self) -> Step:
        """Return the next step; what passes by itself is waited for."""
        told, begun_s = '', time.monotonic()
        while True:
            now_s = time.monotonic()
            situation = self._cell.situation()
            step = self._planned(next_step(situation, now_s))
            silent = situation is not None and not situation.connected
            waits = step.act is Act.WAIT or (silent and now_s < begun_s + CONNECTED_S)
            if step.act not in (Act.WAIT, Act.RELEASE) or not waits:
                return step
            if now_s > begun_s + LONGEST_WAIT_S:
                return step
            if step.words != told:
                told = step.words
                self._person.show(f'waiting: {told}')
            time.sleep(10 * LOOK_S)

    def _planned(self, step: Step) -> Step:
        """Return the step; what could be released must be what can be shown."""
        situation, plan = self._cell.situation(), self._cell.plan()
        if step.act is not Act.RELEASE or situation is None:
            return step
        if plan is not None and plan.plan_hash == situation.plan_hash:
            return step
        return Step(
            Act.WAIT,
            'the plan in hand is not the one of the planner; next: let the planner plan again'
            ' (excitation_planner/plan)',
        )

    def _previewed(self) -> ExcitationPlan:
        plan, situation = self._cell.plan(), self._cell.situation()
        assert plan is not None and situation is not None  # noqa: S101 - as _settled() has seen
        self._person.preview(plan)
        kind = 'an emulated arm' if situation.emulated else 'a REAL arm'
        dry = ', dry run: nothing is sent' if situation.dry_run else ''
        self._person.tell(f'controller {situation.controller}, {kind}{dry}')
        return plan

    def _confirm(self, plan: ExcitationPlan) -> None:
        # What was chosen beforehand is the plan, not the way back to its start.
        chosen = self._chosen if plan.plan_hash != self._way_back else ''
        wanted = chosen or self._person.ask(
            f'type the first {SHORTEST_HASH} letters of its hash to release it ({LEAVE} leaves): '
        )
        wanted = wanted.strip().lower()
        if wanted == LEAVE:
            raise LeftError('left before a release')
        if len(wanted) < SHORTEST_HASH or not plan.plan_hash.startswith(wanted):
            raise BridgeError(
                'not the hash of this plan', found=wanted, expected=plan.plan_hash[:SHORTEST_HASH]
            )

    def _release(self, plan: ExcitationPlan) -> str:
        situation = self._cell.situation()
        controller = situation.controller if situation is not None else ''
        return self._cell.release(plan.plan_hash, controller)

    def _pause(self, words: str) -> None:
        if self._person.ask(f'{words}, {LEAVE} leaves: ').strip().lower() == LEAVE:
            raise LeftError('left; nothing moves')

    # -- while it runs -------------------------------------------------------------------------

    def _hold_to_run(self, token: str) -> Outcome:
        # A key that is read late counts as let go.
        with self._holding() as holding, in_real_time(PRIORITY):
            self._person.tell(holding.words)
            run = HeldRun(self._cell, holding, token)
            try:
                while (outcome := run.look(time.monotonic())) is None:
                    self._show(run)
                    time.sleep(LOOK_S)
            finally:
                run.end()
        self._person.show('')
        time.sleep(SETTLE_S)
        return outcome

    def _show(self, run: HeldRun) -> None:
        now_s = time.monotonic()
        for line in self._cell.windows():
            self._person.tell(line)
        if now_s < run.shown_s + SHOW_S:
            return
        run.shown_s = now_s
        self._person.show(run.words)

    def _show_windows(self, longest_s: float) -> None:
        """Wait for what was identified of the motion."""
        deadline_s = time.monotonic() + longest_s
        while time.monotonic() < deadline_s:
            lines = self._cell.windows()
            for line in lines:
                self._person.tell(line)
            if lines:
                return
            time.sleep(10 * LOOK_S)
