"""What a bridge plays its plans through; one small interface for every kind of controller."""

from abc import ABC, abstractmethod

from excitation_planner.plan import ExcitationPlan
from robot_bridge.egm import Judgement, RobotFeedback
from robot_bridge.operator import OperatorFlow
from robot_bridge.player import PlanPath, Reference


class Backend(ABC):
    """A way to make the arm follow a plan.

    Parameters
    ----------
    name : str
        As the operator knows it.
    flow : OperatorFlow
        Who may move the arm, and when.
    """

    # The controller follows the plan's samples, not moves of its own.
    guides = False

    def __init__(self, name: str, flow: OperatorFlow) -> None:
        self.name = name
        self.flow = flow

    @abstractmethod
    def take(self, plan: ExcitationPlan, path: PlanPath) -> str:
        """Take a checked plan in hand and return what the operator should know.

        Raises
        ------
        ModalAnalysisError
            It cannot be played, or the arm is moving.
        """

    @abstractmethod
    def answer(
        self, feedback: RobotFeedback, judgement: Judgement, now_s: float
    ) -> Reference | None:
        """Take one accepted packet; return what to reply, None for nothing."""

    def start(self, now_s: float, token: str) -> None:
        """Begin to play the armed plan; see :meth:`OperatorFlow.start`."""
        self.flow.start(now_s, token)

    def abort(self, reason: str) -> None:
        """Bring the arm to standstill and latch; returns at once."""
        self.flow.abort(reason)
