"""ros2_control: the plan is played by a joint trajectory controller, and the bridge listens."""

import time

import numpy as np

from excitation_planner.plan import ExcitationPlan
from excitation_planner.signals import MOVES
from modal_core.errors import BridgeError, PlanError
from robot_bridge.backends.backend import Backend
from robot_bridge.backends.released_plans import ReleasedPlans
from robot_bridge.egm import Judgement, RobotFeedback
from robot_bridge.operator import FlowState, StreamFlow
from robot_bridge.player import PlanPath, Reference
from robot_bridge.trajectory import joint_goal, JointGoal, reach, TrajectoryControl


class TrajectoryBackend(Backend):
    """Hands the armed plan over as one trajectory; any abort has it given up.

    The controller has the whole of it from START on: when this process is killed, it plays on.

    Parameters
    ----------
    name : str
        As the operator knows it.
    flow : StreamFlow
        Follows the joints.
    control : TrajectoryControl
        The controller.
    """

    def __init__(self, name: str, flow: StreamFlow, control: TrajectoryControl) -> None:
        super().__init__(name, flow)
        self._control = control
        self._goals: ReleasedPlans[JointGoal] = ReleasedPlans()
        control.on_end = flow.abort
        if not flow.settings.dry_run:
            flow.stop_program = self._stop

    def take(self, plan: ExcitationPlan, path: PlanPath) -> str:
        """Take a plan in hand."""
        if plan.signal not in MOVES:
            raise PlanError(
                'a trajectory controller does not follow this signal', found=plan.signal,
                expected=' or '.join(MOVES), advice='plan random_pulses',
            )  # fmt: skip
        goal = joint_goal(plan)
        before = self.flow.path
        self.flow.offer(path)
        self._goals.keep(before, plan.plan_hash, goal)
        rate_hz = self._control.update_rate_hz
        told = reach(plan, rate_hz) if rate_hz else 'update rate not known yet'
        return f'plan {plan.plan_hash[:12]} checked, {len(goal.time_s)} points; {told}'

    def answer(
        self, feedback: RobotFeedback, judgement: Judgement, now_s: float
    ) -> Reference | None:
        """Follow the joints; reply nothing."""
        return self.flow.on_feedback(feedback, judgement, now_s)

    def start(self, now_s: float, token: str) -> None:
        """Have the armed plan played.

        Raises
        ------
        BridgeError
            Not armed, not the token of the release, no heartbeat, or the controller refuses.
        """
        path = self.flow.path
        goal = self._goals.of(path)
        if self.flow.settings.dry_run or goal is None or path is None:
            self.flow.start(now_s, token)
            return
        if self.flow.state == FlowState.ARMED:
            # Refused here, the release stays and nothing has been touched.
            self._control.check(goal)
            self._check_place(path)
        self.flow.start(time.monotonic(), token)
        try:
            self._control.run(goal, path, self._check_wanted)
            self._check_wanted()
        except BridgeError as error:
            self.flow.abort(str(error))
            self._stop()
            raise

    def _check_place(self, path: PlanPath) -> None:
        """Refuse an arm that is elsewhere: the controller would go to the start in no time."""
        feedback = self.flow.feedback
        if feedback is None:
            raise BridgeError('no joint states')
        tolerance_deg = self.flow.settings.start_tolerance_deg
        distance = np.abs(np.array(feedback.joints_deg) - path.start_deg)
        axis = int(np.argmax(distance))
        if not distance[axis] <= tolerance_deg:
            raise BridgeError(
                f'axis {axis + 1} is not at the start pose of the plan',
                found=f'{feedback.joints_deg[axis]:.3f} deg',
                expected=f'{path.start_deg[axis]:.3f} +- {tolerance_deg:g} deg',
                advice='go there, or release and run an approach plan',
            )

    def _check_wanted(self) -> None:
        if self.flow.state == FlowState.ABORTED:
            raise BridgeError(f'aborted: {self.flow.reason}')

    def _stop(self) -> None:
        try:
            self._control.stop()
        except BridgeError as error:
            self.flow.note(f'NOT STOPPED, use the e-stop: {error}')
