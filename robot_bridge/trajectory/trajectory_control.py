"""What a backend asks of a controller that plays joint trajectories."""

from collections.abc import Callable
from typing import Protocol

from robot_bridge.egm import Answer, SessionLimits
from robot_bridge.player import PlanPath
from robot_bridge.trajectory.joint_goal import JointGoal
from robot_bridge.trajectory.joint_link import JointLink
from structural_model.flexible_joint_model import FlexibleJointModel


class TrajectoryControl(Protocol):
    """Plays trajectories; every method raises BridgeError when it cannot."""

    on_end: Callable[[str], None]
    """Told why a trajectory ended otherwise than at its end."""

    @property
    def update_rate_hz(self) -> float:
        """Rate of the controller as far as it is known; 0: not known."""

    def check(self, goal: JointGoal) -> None:
        """Refuse a robot that is not there, or whose joints are not those of the trajectory."""

    def run(self, goal: JointGoal, path: PlanPath, check_wanted: Callable[[], None]) -> None:
        """Have a trajectory played, if it is still wanted when everything is ready."""

    def stop(self) -> None:
        """Have the trajectory that is played given up."""


class TrajectoryLink(TrajectoryControl, Protocol):
    """The same, and where its joints are."""

    def connect(
        self,
        model: FlexibleJointModel,
        limits: SessionLimits,
        answer: Answer,
        alarm: Callable[[str], None],
        idle: Callable[[float], None],
    ) -> JointLink:
        """Return the link that the joint states go to from now on."""
