"""A robot behind a backend: link, operator flow and packet log, without ROS."""

from collections.abc import Callable
import time

import numpy as np

from excitation_planner.bounds import check_limits, Envelope, PlanLimits
from excitation_planner.plan import ExcitationPlan
from modal_core.errors import BridgeError, PlanError
from robot_bridge.backends import make_backend
from robot_bridge.bridge_settings import BridgeSettings
from robot_bridge.egm import EgmLink, Judgement, Packet, RobotFeedback, SessionCheck, SessionLimits
from robot_bridge.operator import FlowState
from robot_bridge.player import PlanPath, Reference
from robot_bridge.recording import PacketLog
from robot_bridge.trajectory import JointLink, TrajectoryLink
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.robot_writer import robot_content

SPEED_SLACK = 1.2
# Stated peaks have six digits; another machine's libraries may differ in the last bits.
ROUNDED, TINY = 1e-4, 1e-9
LAST_REPLIES_S = 0.2
STANDSTILL_CYCLES = 5
Hear = Callable[[RobotFeedback, int], None]


class Bridge:
    """Listens from the beginning; answers and releases plans once it is activated.

    Parameters
    ----------
    settings : BridgeSettings
        What it is made from.
    model : FlexibleJointModel
        The robot.
    hear : callable
        Given every accepted feedback and the host time of its receipt [ns].
    on_change : callable
        Told every state and the reason for it; called in the thread that enters it.
    robot : TrajectoryLink or None
        A robot under ros2_control; None is one that EGM speaks of.

    Raises
    ------
    ModalAnalysisError
        The backend refuses its settings, the port is in use, the log cannot be made.
    """

    def __init__(
        self,
        settings: BridgeSettings,
        model: FlexibleJointModel,
        hear: Hear,
        on_change: Callable[[FlowState, str], None],
        robot: TrajectoryLink | None = None,
    ) -> None:
        self.settings, self.model = settings, model
        self._hear, self._on_change = hear, on_change
        self.backend = make_backend(settings.backend, model, robot)
        self.flow = self.backend.flow
        self.flow.set_speed_override(settings.speed_override)
        self.flow.deactivate()
        self.flow.mute()
        self.flow.on_change = self._changed
        self.log: PacketLog | None = None
        self.link = self._egm_link() if robot is None else self._joint_link(robot)
        try:
            if settings.packet_log is not None:
                self.log = PacketLog(
                    settings.packet_log, settings.packet_log_bytes, robot_content(model)
                )
            self.link.start()
        except BaseException:
            self.link.close()
            raise

    def _egm_link(self) -> EgmLink | JointLink:
        return EgmLink(
            self.settings.bind_address,
            self.settings.port,
            SessionCheck(self._session_limits()),
            self._answer,
            self.backend.abort,
            self.flow.poll,
            log=self._add_to_log,
            stale_s=self.flow.settings.link_timeout_s,
        )

    def _joint_link(self, robot: TrajectoryLink) -> EgmLink | JointLink:
        return robot.connect(
            self.model, self._session_limits(), self._answer, self.backend.abort, self.flow.poll
        )

    def take(self, plan: ExcitationPlan) -> str:
        """Take a plan in hand, checked as a whole before anything moves.

        Returns
        -------
        str
            What the operator should know.

        Raises
        ------
        ModalAnalysisError
            It is for another robot, breaks a limit, goes beyond what it states of itself, or the
            arm is moving.
        """
        model = self.model
        if plan.robot_name != model.robot_name:
            raise PlanError(
                'plan is for another robot', found=plan.robot_name, expected=model.robot_name
            )
        if plan.joint_names != model.joint_names:
            raise PlanError('plan has other joints', found=plan.joint_names)
        limits = PlanLimits(
            model,
            point_speed_m_s=self.settings.point_speed_m_s,
            guided=self.backend.guides,
        )
        envelope = check_limits(plan.trajectory, limits)
        _check_stated(plan, envelope)
        path = PlanPath.from_trajectory(plan.plan_hash, plan.trajectory, model.to_controller)
        told, worst = self.backend.take(plan, path), envelope.worst
        return (
            f'{told}; fastest point {1e3 * envelope.peak_point_speed_m_s:.0f} mm/s,'
            f' most used is {worst.name} with {100.0 * worst.fraction:.0f} %'
        )

    def release(self, plan_hash: str, controller: str, timeout_s: float, now_s: float) -> str:
        """Release a plan for motion of this bridge's controller; return the token.

        Raises
        ------
        BridgeError
            Another controller is meant, or as :meth:`OperatorFlow.arm`.
        """
        if controller != self.settings.controller:
            raise BridgeError(
                'another controller is meant',
                where='controller',
                found=controller or 'nothing',
                expected=self.settings.controller,
            )
        return self.flow.arm(plan_hash, timeout_s, now_s)

    def come_to_rest(self) -> None:
        """Stop the motion, see it through, then answer no more."""
        flow = self.flow
        flow.deactivate()
        deadline_s = time.monotonic() + flow.settings.player.stop_ramp_s + LAST_REPLIES_S
        while flow.moving and flow.connected and time.monotonic() < deadline_s:
            time.sleep(flow.settings.cycle_s)
        flow.settle()
        # The reference to stand still must have left.
        time.sleep(STANDSTILL_CYCLES * flow.settings.cycle_s)
        flow.mute()

    def close(self) -> None:
        """Come to rest, give the port back, finish the log."""
        self.come_to_rest()
        self.link.close()
        if self.log is not None:
            self.log.close()

    def _session_limits(self) -> SessionLimits:
        speed = np.degrees(self.model.limits.velocity) * SPEED_SLACK
        return SessionLimits(
            cycle_s=self.flow.settings.cycle_s,
            max_speed_deg_s=tuple(speed.tolist()),
            controller_address=self.settings.backend.controller_address,
        )

    def _answer(
        self, feedback: RobotFeedback, judgement: Judgement, now_s: float, receipt_ns: int
    ) -> Reference | None:
        reference = self.backend.answer(feedback, judgement, now_s)
        self._hear(feedback, receipt_ns)
        return reference

    def _add_to_log(self, packet: Packet) -> None:
        if self.log is not None:
            self.log.add(packet)

    def _changed(self, state: FlowState, reason: str) -> None:
        if self.log is not None:
            self.log.add_event(time.time_ns(), f'{state.name}: {reason}')
        self._on_change(state, reason)


def _check_stated(plan: ExcitationPlan, envelope: Envelope) -> None:
    """Refuse a plan that does more than it says: what it says is what a person releases."""
    for name, found in (
        ('peak_point_speed', envelope.peak_point_speed_m_s),
        ('peak_velocity', envelope.peak_velocity),
        ('peak_acceleration', envelope.peak_acceleration),
        ('position_range', np.ptp(plan.position, axis=0)),
    ):
        stated, found = np.atleast_1d(getattr(plan, name)), np.atleast_1d(found)
        beyond = found > stated * (1.0 + ROUNDED) + TINY
        if beyond.any():
            joint = int(np.argmax(beyond))
            raise PlanError(
                'plan goes beyond what it states',
                where=name,
                found=f'{found[joint]:.6g}',
                expected=f'<= {stated[joint]:.6g}',
                advice='plan again; the planner must know the arm as the bridge does',
            )
