"""EGM guidance: the bridge sends position and speed reference in every cycle."""

import time

from excitation_planner.plan import ExcitationPlan
from excitation_planner.rapid import session_s
from modal_core.errors import PlanError
from robot_bridge.backends.backend import Backend
from robot_bridge.egm import Judgement, RobotFeedback
from robot_bridge.operator import OperatorFlow
from robot_bridge.player import PlanPath, ramp_in_s, Reference
from robot_bridge.rws import ProgramControl


class GuidanceBackend(Backend):
    """Guides the joints; needs the controller's EGM option.

    Parameters
    ----------
    name : str
        As the operator knows it.
    flow : OperatorFlow
        Plays the plan.
    control : ProgramControl or None
        Asked at ``start`` whether the controller is in automatic mode; None asks nothing.
    """

    guides = True

    def __init__(
        self, name: str, flow: OperatorFlow, control: ProgramControl | None = None
    ) -> None:
        super().__init__(name, flow)
        self._control = control

    def take(self, plan: ExcitationPlan, path: PlanPath) -> str:
        """Take a plan in hand.

        Raises
        ------
        BridgeError
            The arm is moving.
        PlanError
            It goes so far for its speed that its amplitude cannot be changed while it lasts.
        """
        ramp_s = ramp_in_s(path, self.flow.settings.player)
        if ramp_s > path.duration_s:
            raise PlanError(
                'goes too far for its speed to be guided',
                where='plan',
                found=f'{path.duration_s:.1f} s, of which {ramp_s:.1f} s of ramp-in',
                advice='plan band_limited_noise or a longer plan, or use RAPID',
            )
        self.flow.offer(path, session_s(path.duration_s))
        return f'plan {plan.plan_hash[:12]} checked, waiting to be armed'

    def answer(
        self, feedback: RobotFeedback, judgement: Judgement, now_s: float
    ) -> Reference | None:
        """Reply the reference of this cycle."""
        return self.flow.on_feedback(feedback, judgement, now_s)

    def start(self, now_s: float, token: str) -> None:
        """Begin to play the armed plan.

        Raises
        ------
        BridgeError
            Not armed or not ready, or the controller is not in automatic mode or does not say so.
        """
        if self._control is not None and not self.flow.settings.dry_run:
            self._control.check_automatic()
            now_s = time.monotonic()
        self.flow.start(now_s, token)
