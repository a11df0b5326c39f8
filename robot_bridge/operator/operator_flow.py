"""Who may move the arm, when, and what stops it: the bridge's state machine.

Nothing moves without a plan, ``arm`` with the plan's hash, and ``start`` at the plan's start pose
with the motors on.  Whatever goes wrong while moving ends in ABORTED: the motion slows down to
standstill, the arm is held there, and only ``reset`` leaves the state.  Time comes in from
outside.

This is not a safety function (ISO 10218): the controller's limits, guards and e-stop stay in
charge.
"""

import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import BridgeError
from robot_bridge.egm import Judgement, MCI_RUNNING, RobotFeedback, Verdict
from robot_bridge.operator.flow_base import FlowBase
from robot_bridge.operator.flow_settings import FlowSettings, FlowState, not_ready
from robot_bridge.operator.following_check import FollowingCheck
from robot_bridge.operator.lateness import Lateness
from robot_bridge.operator.pace_check import PaceCheck
from robot_bridge.player import PlanPath, PlanPlayer, Reference

Array = NDArray[np.float64]
LONGEST_ARM_S = 300.0
STRAYS = 'it goes away from where it is asked to stay: no answer until its session begins anew'


class OperatorFlow(FlowBase):
    """The state machine; every method may be called from any thread.

    Parameters
    ----------
    settings : FlowSettings
        Limits.
    """

    def __init__(self, settings: FlowSettings) -> None:
        super().__init__(settings)
        self._longest_arm_s = LONGEST_ARM_S
        self._n_pulls, self._strays = 0, False
        self._following: FollowingCheck | None = None
        self._pace = PaceCheck(settings.cycle_s)
        self._lateness = Lateness(settings.cycle_s, settings.link_timeout_s)

    # -- the operator --------------------------------------------------------------------------

    def offer(self, path: PlanPath, longest_arm_s: float = LONGEST_ARM_S) -> None:
        """Take a plan in hand; the plan that is in hand, by its hash, changes nothing.

        It may come late or again: a release of it stays, and it neither releases nor starts.

        Parameters
        ----------
        path : PlanPath
            The plan.
        longest_arm_s : float [s]
            Longest release of it.

        Raises
        ------
        BridgeError
            The arm is moving.
        """
        with self._lock:
            self.check_free()
            if self.path is not None and self.path.plan_hash == path.plan_hash:
                return
            self.path = path
            self._longest_arm_s = min(longest_arm_s, LONGEST_ARM_S)
            if self.state in (FlowState.ARMED, FlowState.HOLDING):
                self._enter(FlowState.IDLE, 'a new plan arrived')

    def check_free(self) -> None:
        """Refuse a new plan now.

        Raises
        ------
        BridgeError
            The arm is moving.
        """
        if self.busy:
            raise BridgeError('a plan cannot be changed while it is played')

    def arm(self, plan_hash: str, timeout_s: float, now_s: float) -> str:
        """Release the plan with this hash for a while and return the token of the release.

        Raises
        ------
        BridgeError
            No such plan, a bad time-out, no robot, another bridge of this name, or a latched
            abort.
        """
        with self._lock:
            if self.path is None:
                raise BridgeError('no plan to arm', advice='wait for the planner')
            if plan_hash != self.path.plan_hash:
                raise BridgeError(
                    'plan_hash is not the hash of the plan in hand',
                    found=plan_hash[:16] or 'nothing',
                    expected=self.path.plan_hash[:16],
                )
            if not 0.0 < timeout_s <= self._longest_arm_s:
                raise BridgeError(
                    'bad timeout_s', found=timeout_s, expected=f'0..{self._longest_arm_s:g} s'
                )
            if not self.active:
                raise BridgeError('the bridge is not active', advice='activate it first')
            self._check_alone()
            if not self._may_arm():
                raise BridgeError(f'cannot arm while {self.state.name}', found=self.reason)
            token = self.release.grant(now_s + timeout_s)
            self._enter(FlowState.ARMED, f'armed for {timeout_s:g} s')
            return token

    def start(self, now_s: float, token: str) -> None:
        """Begin to play the armed plan, for who armed it.

        Raises
        ------
        BridgeError
            Not armed, not the token of the release, the heartbeat is missing, the controller's
            period is not ``cycle_s``, the session is not running, motors are off, or the arm is
            not at the plan's start pose.
        """
        with self._lock:
            self._check_released(now_s, token)
            path, feedback, hold = self.path, self.feedback, self._hold
            if path is None or feedback is None:
                raise BridgeError('no plan or no feedback')
            if hold is None:
                raise BridgeError('the controller does not hold where the arm stands')
            self._pace.check()
            blocked = None if self.settings.dry_run else not_ready(feedback)
            if blocked:
                raise BridgeError(f'the controller is not ready: {blocked}')
            for place in (np.array(feedback.joints_deg), hold):
                distance = np.abs(place - path.start_deg)
                if distance.max() > self.settings.start_tolerance_deg:
                    axis = int(np.argmax(distance))
                    raise BridgeError(
                        f'axis {axis + 1} is not at the start pose of the plan',
                        found=f'{place[axis]:.3f} deg',
                        expected=f'{path.start_deg[axis]:.3f} +- '
                        f'{self.settings.start_tolerance_deg:g} deg',
                    )
            self._player = PlanPlayer(path, hold, self.settings.player, self._override)
            self._follow_plan(path, hold, feedback, self._lateness)
            self._enter(FlowState.RUNNING, 'started by the operator')

    def reset(self) -> None:
        """Leave a latched abort; the arm stays where it is and nothing is armed.

        Raises
        ------
        BridgeError
            Nothing to reset, or the arm has not come to rest.
        """
        with self._lock:
            if self.state != FlowState.ABORTED:
                raise BridgeError(f'nothing to reset while {self.state.name}')
            if self.moving:
                raise BridgeError('still slowing down')
            self._check_alone()
            self._player = None
            self._enter(FlowState.IDLE, 'reset by the operator')

    # -- the controller ------------------------------------------------------------------------

    def on_feedback(
        self, feedback: RobotFeedback, judgement: Judgement, now_s: float
    ) -> Reference | None:
        """Take one accepted packet and return the reference to reply, None for no reply."""
        with self._lock:
            # Not poll(): a late packet must still find the silence before it.
            self._watch(now_s)
            before, self.feedback, self._heard_s = self.feedback, feedback, now_s
            begins = judgement.verdict == Verdict.NEW_SESSION
            self._pace.add(feedback, begins=begins)
            self._lateness.add(judgement.n_steps, now_s, begins=begins)
            self._watch_controller(before, feedback, judgement)
            if self.state == FlowState.DISCONNECTED:
                self._enter(FlowState.IDLE, 'the controller is heard')
            if self._is_elsewhere(before, feedback, judgement):
                # Whatever the controller holds is what we ask for: no jump when guidance begins.
                if not self.settings.dry_run or self._player is None:
                    self._player = None
                self._hold = np.array(feedback.planned_deg)
                if self._strays or not self._agrees(feedback):
                    if not self.settings.dry_run:
                        self._hold = None  # nor is it asked for in the next cycle
                    return None
            reference = self._reference(judgement.n_steps)
            self._watch_following(reference.position_deg, feedback, judgement.n_steps)
            return None if self.settings.dry_run or self.muted else reference

    def poll(self, now_s: float) -> None:
        """Let time pass: link, heartbeat and release may run out."""
        with self._lock:
            self._watch(now_s)

    # -- inside --------------------------------------------------------------------------------

    def _reference(self, n_steps: int) -> Reference:
        hold = self._hold
        if hold is None:
            raise BridgeError('no feedback')
        player = self._player
        if player is None:
            return Reference(hold, np.zeros_like(hold))
        for _ in range(min(n_steps, self.settings.most_missed_cycles + 1)):
            reference = player.step(self.settings.cycle_s)
        self._hold = player.position_deg
        if player.at_rest and self.state == FlowState.RUNNING:
            self._player = None
            self._enter(FlowState.HOLDING, 'the plan is at its end')
        return reference

    def _watch(self, now_s: float) -> None:
        if self._heard_s > -math.inf and now_s - self._heard_s > self.settings.link_timeout_s:
            silence = now_s - self._heard_s
            self._heard_s = -math.inf
            if self.state in (FlowState.RUNNING, FlowState.ARMED):
                self.abort(f'link lost: no feedback for {1e3 * silence:.0f} ms')
            elif self.state != FlowState.ABORTED:
                self._enter(FlowState.DISCONNECTED, 'no feedback')
            self.feedback = None  # the next packet says where the arm is
        if self.state == FlowState.ARMED and self.release.over(now_s):
            self._enter(FlowState.IDLE, 'the release timed out')
        if self.state == FlowState.RUNNING and self._heartbeat_lost(now_s):
            self.abort('the operator heartbeat is lost')

    def _may_arm(self) -> bool:
        return self.state in (FlowState.IDLE, FlowState.HOLDING, FlowState.ARMED)

    def _heartbeat_lost(self, now_s: float) -> bool:
        self.hear()
        return self.release.silent(now_s, self.settings.heartbeat_timeout_s)

    def _check_released(self, now_s: float, token: str) -> None:
        """Refuse to start what is not released, or for who did not release it."""
        self.poll(now_s)
        if self.state != FlowState.ARMED:
            raise BridgeError(f'not armed but {self.state.name}', found=self.reason)
        self._check_alone()
        if not self.release.is_of(token):
            raise BridgeError('not the token of this release', advice='arm answers it')
        if self._heartbeat_lost(now_s):
            raise BridgeError(
                'no heartbeat of the operator', expected='>= 10 Hz, with the token of the release'
            )

    def _watch_controller(
        self, before: RobotFeedback | None, feedback: RobotFeedback, judgement: Judgement
    ) -> None:
        if self.state not in (FlowState.RUNNING, FlowState.ARMED):
            return
        if judgement.verdict == Verdict.NEW_SESSION:
            self.abort(f'the session began anew: {judgement.reason}')
        elif judgement.n_steps > self.settings.most_missed_cycles + 1:
            self.abort(f'link lost: {judgement.n_steps - 1} packets missing')
        elif self.state == FlowState.RUNNING and not self.settings.dry_run:
            blocked = not_ready(feedback)
            if blocked:
                self.abort(blocked)
        elif self.state == FlowState.ARMED and not self.settings.dry_run:
            ran = before is not None and before.mci_state == MCI_RUNNING
            if ran and feedback.mci_state != MCI_RUNNING:
                name = feedback.mci_name
                self._enter(FlowState.IDLE, f'the release has ended: the EGM session is {name}')

    def _follow_plan(
        self,
        path: PlanPath,
        hold: Array,
        feedback: RobotFeedback,
        lateness: Lateness | None = None,
    ) -> None:
        cycle_s, largest_deg = self.settings.cycle_s, self.settings.max_following_error_deg
        self._following = FollowingCheck(path, hold, feedback, cycle_s, largest_deg, lateness)

    def _watch_following(
        self, reference_deg: Array, feedback: RobotFeedback, n_steps: int
    ) -> None:
        following = self._following
        if self.state != FlowState.RUNNING or following is None or self.settings.dry_run:
            return
        fault = following.fault(reference_deg, feedback, n_steps)
        if fault:
            self.abort(fault)

    def _is_elsewhere(
        self, before: RobotFeedback | None, feedback: RobotFeedback, judgement: Judgement
    ) -> bool:
        """Tell whether the controller does not stand where it was asked to last.

        What it held while it was not guided counts until the first packet that says it is.  A
        guided controller that leaves where it is asked to stay would be chased: asking is what
        moves it.  In motion it is asked once to stay where it is, since the last reference, which
        goes on without an answer, holds a speed.
        """
        fresh = before is None or judgement.verdict == Verdict.NEW_SESSION
        stays, pulled = not self.moving, self._pulled_away(feedback)
        guided = before is not None and {before.mci_state, feedback.mci_state} == {MCI_RUNNING}
        if fresh or not guided:
            self._n_pulls, self._strays = 0, False
        elif pulled:
            self._n_pulls += 1
            self._strays = stays or self._n_pulls > 1
        if pulled and self._strays:
            self.abort(STRAYS)
            self.note(STRAYS)
        return fresh or pulled or not guided or self._hold is None

    def _agrees(self, feedback: RobotFeedback) -> bool:
        """Tell whether what the controller holds may be true: where the arm stands."""
        error = np.abs(np.array(feedback.planned_deg) - np.array(feedback.joints_deg))
        return bool(error.max() <= self.settings.max_following_error_deg)

    def _pulled_away(self, feedback: RobotFeedback) -> bool:
        """Tell whether the controller stands elsewhere: asking it to come back is no hold."""
        if self._hold is None or self.settings.dry_run:
            return False
        error = np.abs(np.array(feedback.planned_deg) - self._hold)
        away = bool(error.max() > self.settings.max_following_error_deg)
        if away and self.state in (FlowState.RUNNING, FlowState.ARMED):
            axis = int(np.argmax(error))
            self.abort(f'the controller stands {error[axis]:.2f} deg away on axis {axis + 1}')
        return away
