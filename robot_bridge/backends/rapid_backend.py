"""RAPID: the plan runs as a program of the controller, and the bridge only listens."""

from pathlib import Path
import time

from excitation_planner.plan import ExcitationPlan
from excitation_planner.rapid import module_name, rapid_module, start_tolerance_deg
from excitation_planner.rapid_options import RapidOptions
from excitation_planner.signals import MOVES
from modal_core.errors import BridgeError, PlanError
from modal_core.files.atomic_file import write_text
from robot_bridge.backends.backend import Backend
from robot_bridge.backends.released_plans import ReleasedPlans
from robot_bridge.egm import Judgement, RobotFeedback
from robot_bridge.operator import FlowState, StreamFlow
from robot_bridge.player import PlanPath, Reference
from robot_bridge.rws import ProgramControl, ReleasedProgram
from structural_model.flexible_joint_model import FlexibleJointModel

# Between stops while a start is under way: what a program may go on for at the most. A stop itself
# takes about 0.1 s to standstill (docs/reference/abb.md), so that more often would gain nothing.
STOP_AGAIN_S = 0.1


class RapidBackend(Backend):
    """Writes each plan as a RAPID module, started through a control or by hand at the pendant.

    The controller streams its joints by EGM while the program runs; nothing is ever replied.
    Without a control the bridge cannot stop the arm either: the pendant can.

    Parameters
    ----------
    name : str
        As the operator knows it.
    flow : StreamFlow
        Follows the program by its stream.
    model : FlexibleJointModel
        Robot of the plans.
    path : Path
        File the module is written to, whole or not at all.
    control : ProgramControl or None
        Loads, starts and stops the program; None leaves that to a person.
    options : RapidOptions or None
        How the module is written.

    Raises
    ------
    BridgeError
        The program would not stream.
    """

    def __init__(
        self,
        name: str,
        flow: StreamFlow,
        model: FlexibleJointModel,
        path: Path,
        control: ProgramControl | None = None,
        options: RapidOptions | None = None,
    ) -> None:
        super().__init__(name, flow)
        self._model, self._path, self._control = model, path, control
        self._options = options or RapidOptions()
        self._options.check()
        if not self._options.stream:
            raise BridgeError(
                'the bridge follows a program by its stream', where='rapid.stream', found='false',
                advice='without option 689-1 use ama plan --rapid --no-stream, without the bridge',
            )  # fmt: skip
        self._programs: ReleasedPlans[ReleasedProgram] = ReleasedPlans()
        self._being_started = False
        if control is not None and not flow.settings.dry_run:
            flow.stop_program = self._stop

    def take(self, plan: ExcitationPlan, path: PlanPath) -> str:
        """Write the module of a plan and take the plan in hand."""
        if plan.signal not in MOVES:
            raise PlanError(
                'a RAPID program cannot play this signal',
                found=plan.signal,
                expected=' or '.join(MOVES),
                advice='plan random_pulses, or use EGM guidance',
            )
        program = ReleasedProgram(
            name=module_name(plan, self._options),
            text=rapid_module(plan, self._model, self._options),
            start_deg=tuple(path.start_deg.tolist()),
            tolerance_deg=start_tolerance_deg(plan),
        )
        self._programs.keep(self.flow.path, plan.plan_hash, program)
        self.flow.offer(path)
        write_text(self._path, program.text)
        return f'plan {plan.plan_hash[:12]} checked and written to {self._path}'

    def answer(
        self, feedback: RobotFeedback, judgement: Judgement, now_s: float
    ) -> Reference | None:
        """Follow the program; reply nothing."""
        return self.flow.on_feedback(feedback, judgement, now_s)

    def start(self, now_s: float, token: str) -> None:
        """Begin: with a control, load and run the armed module.

        Raises
        ------
        BridgeError
            Not armed, not the token of the release, no heartbeat, or the controller refuses.
        """
        control = None if self.flow.settings.dry_run else self._control
        program = self._programs.of(self.flow.path)
        if control is None or program is None:
            self.flow.start(now_s, token)
            return
        if self.flow.state == FlowState.ARMED:
            # Refused here, the release stays and nothing has been touched.
            control.check(program)
        self.flow.start(now_s, token)
        try:
            control.load(program)
            self._check_wanted()
            self._being_started = True
            try:
                control.run(program, self._check_wanted)
            finally:
                self._being_started = False
            # Aborted while it was being started: the stop may have come before the start.
            self._check_wanted()
        except BridgeError as error:
            self.flow.abort(str(error))
            self._stop()
            raise

    def _check_wanted(self) -> None:
        if self.flow.state == FlowState.ABORTED:
            raise BridgeError(f'aborted: {self.flow.reason}')

    def _stop(self) -> None:
        """Stop the program; while START is under way again and again: it may act any moment."""
        if self._control is None:
            return
        try:
            self._control.stop()
            while self._being_started:
                time.sleep(STOP_AGAIN_S)
                self._control.stop()
        except BridgeError as error:
            self.flow.note(f'NOT STOPPED, use the pendant: {error}')
