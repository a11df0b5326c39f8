"""The planner as a ROS node: parameters in, a sealed plan out; nothing here moves a robot."""

from collections.abc import Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
from rcl_interfaces.msg import SetParametersResult
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from excitation_planner.closed_loop import next_step, plan_next, Targets
from excitation_planner.forecast import ExpectedModes
from excitation_planner.node.latest_joints_node import LatestJoints
from excitation_planner.node.planner_parameters import PARAMETERS, REQUEST
from excitation_planner.plan import ExcitationPlan
from excitation_planner.planner import plan_excitation, plan_limits
from excitation_planner.request import PlanRequest
from excitation_planner.ros_messages import (
    expected_from_message,
    modes_from_message,
    plan_to_message,
    trajectory_message,
)
from excitation_planner.setting import start_of
from excitation_planner.signals import APPROACH
from excitation_planner.ways import is_there, plan_way_back
from modal_core.errors import ModalAnalysisError, PlanError
from modal_core.nodes.ros_messages import (
    declare_parameters,
    diagnostic,
    LATCHED,
    parameter_mapping,
)
from modal_core.nodes.run_node import run_node
from modal_core.settings.schema import from_parameters
from oma_msgs.msg import ExcitationPlan as PlanMessage
from oma_msgs.msg import ModalParameters, PredictedModes
from structural_model.robot_files import load_layout, load_robot

DIAGNOSTICS_PERIOD_S = 1.0
SAME_POSE_RAD = 0.05
"""Within which a map's modes are those of a plan's start; the tracker's poses are as wide."""
# rclpy has no empty list of a type: this stands for an empty one.


class PlannerNode(Node):
    """Plans on start, on request (``~/plan``) and, in closed loop, after each window.

    ``~/plan_way_back`` plans the way back to the start of its plan, from where the arm stands.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__('excitation_planner', **options)
        declare_parameters(self, PARAMETERS)
        self.model = load_robot(self.get_parameter('robot').value)
        self.layout = load_layout(
            self.get_parameter('robot').value, self.get_parameter('sensors').value
        )
        self.request = self._request({})
        self.plan: ExcitationPlan | None = None
        self.finished = False
        self.last_error = ''
        self.n_plans = self.n_refused = self.n_bad_messages = 0
        self.add_on_set_parameters_callback(self._accept)
        self.plans = self.create_publisher(PlanMessage, '~/excitation_plan', LATCHED)
        self.trajectories = self.create_publisher(JointTrajectory, '~/joint_trajectory', LATCHED)
        self.diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        group = MutuallyExclusiveCallbackGroup()
        self.create_service(Trigger, '~/plan', self._on_plan, callback_group=group)
        self.create_service(Trigger, '~/plan_way_back', self._on_way_back, callback_group=group)
        self._joints = LatestJoints(self, self.model.joint_names)
        self.create_subscription(
            ModalParameters,
            'oma_identifier/modal_parameters',
            self._on_modes,
            LATCHED,
            callback_group=group,
        )
        self.expected: ExpectedModes | None = None
        if topic := self.get_parameter('predicted_modes_topic').value:
            self.create_subscription(
                PredictedModes, topic, self._on_predicted, LATCHED, callback_group=group
            )
        self.create_timer(DIAGNOSTICS_PERIOD_S, self._publish_diagnostics)
        if self.get_parameter('plan_on_start').value:
            self._plan_again(self.request)

    # -- parameters ----------------------------------------------------------------------------

    def _request(self, changes: dict[str, Any]) -> PlanRequest:
        """Build the request from the parameters, some of them about to change."""
        given = {name: value for name, value in changes.items() if value is not None}
        values = from_parameters(PlanRequest, parameter_mapping(self, REQUEST) | given)
        pose = changes.get('start_pose', self.get_parameter('start_pose').value)
        if pose:
            values['start_position'] = tuple(float(angle) for angle in self.model.pose(pose))
        return PlanRequest(**values)

    def _accept(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        """Refuse parameters that do not make a request; keep the old ones."""
        try:
            request = self._request({item.name: item.value for item in parameters})
        except ModalAnalysisError as error:
            return SetParametersResult(successful=False, reason=str(error))
        self.request, self.finished = request, False
        return SetParametersResult(successful=True)

    # -- planning ------------------------------------------------------------------------------

    def _on_plan(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.finished = False
        plan = self._plan_again(self.request)
        response.success = plan is not None
        response.message = plan.plan_hash if plan is not None else self.last_error
        return response

    def _on_way_back(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Publish the way back to the start of the plan; where the arm is there, the plan."""
        try:
            found = self._way_back()
            self._publish(found)
            response.success, response.message = True, found.plan_hash
        except ModalAnalysisError as error:
            response.message = str(error)
            self.get_logger().warning(response.message)
        return response

    def _way_back(self) -> ExcitationPlan:
        plan = self.plan
        if plan is None:
            raise PlanError('no plan to go back to the start of', where='way back')
        here = self._joints.position()
        if is_there(here, plan):
            return plan
        return plan_way_back(here, plan, plan_limits(self.model, self.request))

    def _on_modes(self, message: ModalParameters) -> None:
        """Plan the next window, if the loop is closed and not yet at its end."""
        if not self.get_parameter('closed_loop').value or self.finished or self.plan is None:
            return
        try:
            modes = modes_from_message(message)
        except ModalAnalysisError as error:
            self.n_bad_messages += 1
            self.get_logger().warning(str(error), throttle_duration_sec=5.0)
            return
        targets = Targets(
            frequency_std_ratio=self.get_parameter('target_frequency_std_ratio').value,
            damping_ratio_std_ratio=self.get_parameter('target_damping_ratio_std_ratio').value,
            longest_s=self.get_parameter('longest_window_s').value,
        )
        step = next_step(self.request, modes, targets)
        self.get_logger().info(step.reason)
        self.finished = step.done
        if not step.done:
            self.request = step.request
            self._plan_again(step.request, give_way=True)

    def _on_predicted(self, message: PredictedModes) -> None:
        """Keep what a map expects where the arm is."""
        try:
            self.expected = expected_from_message(message, self.model.joint_names)
        except ModalAnalysisError as error:
            self.n_bad_messages += 1
            self.get_logger().warning(str(error), throttle_duration_sec=5.0)

    def _expected(self, request: PlanRequest) -> ExpectedModes | None:
        """Return what a map expects where a plan starts; None where it tells of elsewhere."""
        found = self.expected
        if found is None or not len(found.frequency_hz) or request.signal == APPROACH:
            return None
        away = np.max(np.abs(found.joints - start_of(self.model, request)))
        return found if away <= SAME_POSE_RAD else None

    def _plan_again(self, request: PlanRequest, give_way: bool = False) -> ExcitationPlan | None:
        try:
            expected = self._expected(request)
            # A spectrum that is raised somewhere may have to give way to the limits.
            make = plan_next if give_way or expected is not None else plan_excitation
            plan = make(self.model, self.layout, request, expected)
        except ModalAnalysisError as error:
            self.n_refused += 1
            self.last_error = str(error)
            self.get_logger().error(self.last_error)
            return None
        self.plan, self.last_error = plan, ''
        self.n_plans += 1
        self._publish(plan)
        for notice in plan.prediction.notices if plan.prediction else ():
            self.get_logger().warning(notice)
        return plan

    def _publish(self, plan: ExcitationPlan) -> None:
        stamp = self.get_clock().now().to_msg()
        message, trajectory = plan_to_message(plan), trajectory_message(plan)
        message.header.stamp = trajectory.header.stamp = stamp
        self.plans.publish(message)
        self.trajectories.publish(trajectory)
        self.get_logger().info(f'plan {plan.plan_hash[:12]} of {plan.duration_s:g} s published')

    def _publish_diagnostics(self) -> None:
        array = DiagnosticArray()
        array.header.stamp = self.get_clock().now().to_msg()
        level, code = DiagnosticStatus.OK, 'PLAN_READY'
        if self.last_error:
            level, code = DiagnosticStatus.ERROR, f'PLAN_REFUSED {self.last_error}'
        elif self.plan is None:
            level, code = DiagnosticStatus.WARN, 'NO_PLAN'
        values = {
            'plan_hash': self.plan.plan_hash if self.plan else '',
            'plans': self.n_plans,
            'refused': self.n_refused,
            'bad_messages': self.n_bad_messages,
            'closed_loop_finished': self.finished,
        }
        name = f'{self.get_fully_qualified_name()}: plan'
        array.status = [diagnostic(name, code, level, values)]
        self.diagnostics.publish(array)


def main(args: Sequence[str] | None = None) -> None:
    """Run the node until it is stopped."""
    run_node('excitation_planner', PlannerNode, args=args)


if __name__ == '__main__':
    main()
