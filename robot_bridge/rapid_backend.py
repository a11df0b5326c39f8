"""RAPID: the plan runs as a program of the controller, and the bridge only listens."""

from pathlib import Path

from excitation_planner.plan import ExcitationPlan, RANDOM_PULSES
from excitation_planner.rapid import rapid_module, RapidOptions
from modal_core.atomic_file import write_text
from modal_core.errors import BridgeError, PlanError
from robot_bridge.backend import Backend
from robot_bridge.egm_feedback import RobotFeedback
from robot_bridge.operator_flow import FlowState
from robot_bridge.plan_path import PlanPath
from robot_bridge.plan_player import Reference
from robot_bridge.rws_client import ProgramControl
from robot_bridge.session_check import Judgement
from robot_bridge.stream_flow import StreamFlow
from structural_model.flexible_joint_model import FlexibleJointModel


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
    """

    def __init__(
        self,
        name: str,
        flow: StreamFlow,
        model: FlexibleJointModel,
        path: Path,
        control: ProgramControl | None = None,
    ) -> None:
        super().__init__(name, flow)
        self._model, self._path, self._control = model, path, control
        self._modules: dict[str, str] = {}
        if control is not None and not flow.settings.dry_run:
            flow.stop_program = self._stop

    def take(self, plan: ExcitationPlan, path: PlanPath) -> str:
        """Write the module of a plan and take the plan in hand."""
        if plan.signal != RANDOM_PULSES:
            raise PlanError(
                'a RAPID program cannot play this signal',
                found=plan.signal,
                expected=RANDOM_PULSES,
                advice='plan random_pulses, or use EGM guidance',
            )
        module = rapid_module(plan, self._model)
        # Kept by hash: what is started is what was armed, whatever arrives in between.
        kept = self.flow.path.plan_hash if self.flow.path is not None else ''
        self._modules = {kept: self._modules.get(kept, ''), plan.plan_hash: module}
        self.flow.offer(path)
        write_text(self._path, module)
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
        self.flow.start(now_s, token)
        if self._control is None or self.flow.settings.dry_run:
            return
        armed = self.flow.path.plan_hash if self.flow.path is not None else ''
        try:
            self._control.load(RapidOptions().module_name, self._modules[armed])
            self._check_wanted()
            self._control.run()
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
        try:
            if self._control is not None:
                self._control.stop()
        except BridgeError as error:
            self.flow.note(f'NOT STOPPED, use the pendant: {error}')
