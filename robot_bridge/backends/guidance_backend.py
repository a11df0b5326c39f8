"""EGM guidance: the bridge sends position and speed reference in every cycle."""

import time

import numpy as np

from excitation_planner.plan import ExcitationPlan
from excitation_planner.rapid import session_s
from modal_core.errors import PlanError
from robot_bridge.backends.backend import Backend
from robot_bridge.egm import Judgement, RobotFeedback
from robot_bridge.operator import OperatorFlow
from robot_bridge.player import PlanPath, Reference
from robot_bridge.rws import ProgramControl

# What a controller holds itself lags behind its reference by 10 to 20 ms (application manual
# Externally Guided Motion, 3HAC073318-001); the bridge stops where that is too far away.
LAG_S = 0.02


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
            It is so fast that a controller that follows would be stopped for its lag.
        """
        speed_deg_s = np.abs(path.coefficients[-2]).max(axis=0)
        axis = int(np.argmax(speed_deg_s))
        fastest_deg_s = self.flow.settings.max_following_error_deg / LAG_S
        if speed_deg_s[axis] > fastest_deg_s:
            raise PlanError(
                f'axis {axis + 1} is too fast to be guided',
                where='plan',
                found=f'{speed_deg_s[axis]:.1f} deg/s',
                expected=f'<= {fastest_deg_s:.1f} deg/s',
                advice='lower speed_high or half_range, plan noise, or use RAPID',
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
