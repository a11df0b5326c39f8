"""EGM guidance: the bridge sends position and speed reference in every cycle."""

from excitation_planner.plan import ExcitationPlan
from modal_core.errors import BridgeError
from robot_bridge.backend import Backend
from robot_bridge.egm_feedback import RobotFeedback
from robot_bridge.operator_flow import OperatorFlow
from robot_bridge.plan_path import PlanPath
from robot_bridge.plan_player import Reference
from robot_bridge.session_check import Judgement


class GuidanceBackend(Backend):
    """Guides the joints; needs the controller's EGM option and an explicit yes.

    Parameters
    ----------
    name : str
        As the operator knows it.
    flow : OperatorFlow
        Plays the plan.
    enabled : bool
        The operator has enabled guidance; not needed in a dry run.

    Raises
    ------
    BridgeError
        Guidance is not enabled.
    """

    guides = True

    def __init__(self, name: str, flow: OperatorFlow, enabled: bool) -> None:
        super().__init__(name, flow)
        if not enabled and not flow.settings.dry_run:
            raise BridgeError(
                'guidance is not enabled',
                where=name,
                advice='read docs/abb.md, then set guidance_enabled true, or use method rapid',
            )

    def take(self, plan: ExcitationPlan, path: PlanPath) -> str:
        """Take a plan in hand."""
        self.flow.offer(path)
        return f'plan {plan.plan_hash[:12]} checked, waiting to be armed'

    def answer(
        self, feedback: RobotFeedback, judgement: Judgement, now_s: float
    ) -> Reference | None:
        """Reply the reference of this cycle."""
        return self.flow.on_feedback(feedback, judgement, now_s)
