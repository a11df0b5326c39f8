"""The planner on real rclpy: latched plan, service, parameters, closed loop, bad input."""

import threading
import time

import numpy as np
import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from excitation_planner.node.planner_node import LATCHED, PlannerNode
from excitation_planner.plan import plan_hash
from excitation_planner.ros_messages import plan_from_message
from modal_core.errors import MessageError
from oma_msgs.msg import ExcitationPlan as PlanMessage
from oma_msgs.msg import ModalParameters, Mode, PredictedModes

pytestmark = pytest.mark.node


class Cell:
    """A planner and a node that listens to it."""

    def __init__(self, context, **parameters):
        self.executor = SingleThreadedExecutor(context=context)
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        self.planner = PlannerNode(context=context, parameter_overrides=overrides)
        # Later than the first plan: what it gets is what the publisher latched.
        self.user = Node('user', context=context)
        self.plans, self.trajectories = [], []
        self.user.create_subscription(
            PlanMessage, '/excitation_planner/excitation_plan', self.plans.append, LATCHED
        )
        self.user.create_subscription(
            JointTrajectory,
            '/excitation_planner/joint_trajectory',
            self.trajectories.append,
            LATCHED,
        )
        self.modes = self.user.create_publisher(
            ModalParameters, '/oma_identifier/modal_parameters', LATCHED
        )
        self.client = self.user.create_client(Trigger, '/excitation_planner/plan')
        self.back = self.user.create_client(Trigger, '/excitation_planner/plan_way_back')
        self.joints = self.user.create_publisher(JointState, '/joint_states', 10)
        for node in (self.planner, self.user):
            self.executor.add_node(node)

    def way_back(self, away_rad=None):
        """Ask for the way back with an arm so far from the start; None: nothing is told of it."""
        self.until(lambda: self.plans and self.back.service_is_ready())
        closing = threading.Event()

        def tell():
            while away_rad is not None and not closing.wait(0.02):
                place = self.planner.plan.start_position + np.array(away_rad)
                names = ['another', *self.planner.model.joint_names]
                self.joints.publish(JointState(name=names, position=[7.0, *place]))

        thread = threading.Thread(target=tell)
        thread.start()
        future = self.back.call_async(Trigger.Request())
        self.until(future.done)
        closing.set()
        thread.join()
        return future.result()

    def until(self, condition, patience_s=20.0):
        deadline = time.monotonic() + patience_s
        while not condition() and time.monotonic() < deadline:
            self.executor.spin_once(timeout_sec=0.1)
        assert condition()


@pytest.fixture
def cell(ros_context):
    made = []

    def make(**parameters):
        made.append(Cell(ros_context, **{'duration_s': 4.0, **parameters}))
        return made[-1]

    yield make
    for item in made:
        item.executor.shutdown()
        item.planner.destroy_node()
        item.user.destroy_node()


@pytest.mark.smoke
def test_late_joiner_gets_the_plan_and_can_recompute_its_hash(cell):
    here = cell()
    here.until(lambda: here.plans and here.trajectories)
    plan = plan_from_message(here.plans[0])
    assert plan_hash(plan) == here.planner.plan.plan_hash
    assert np.array_equal(plan.position, here.planner.plan.position)
    points = here.trajectories[0].points
    assert len(points) == plan.n_samples
    assert points[-1].time_from_start.sec == 4
    assert np.allclose(points[500].positions, plan.position[500], atol=0.0)


def test_service_plans_anew_after_a_parameter_change(cell):
    here = cell()
    here.until(lambda: here.plans and here.client.service_is_ready())
    result = here.planner.set_parameters([Parameter('seed', value=9)])
    assert result[0].successful
    future = here.client.call_async(Trigger.Request())
    here.until(lambda: future.done() and len(here.plans) == 2)
    assert future.result().success
    assert future.result().message == here.plans[1].plan_hash != here.plans[0].plan_hash
    assert here.plans[1].seed == 9


@pytest.mark.parametrize(
    ('name', 'value', 'word'),
    [
        ('duration_s', 1.0, 'duration_s'),
        ('signal', 'sweep', 'sweep'),
        ('band_high_hz', 80.0, '60 Hz'),
    ],
)
def test_bad_parameters_are_refused_and_the_old_kept(cell, name, value, word):
    here = cell()
    before = here.planner.request
    result = here.planner.set_parameters([Parameter(name, value=value)])[0]
    assert not result.successful
    assert word in result.reason
    assert here.planner.request == before


def test_a_refused_plan_is_said_and_not_published(cell):
    here = cell(signal='band_limited_noise', acceleration_rms=20.0)
    here.until(lambda: here.client.service_is_ready())
    future = here.client.call_async(Trigger.Request())
    here.until(future.done)
    assert not future.result().success
    assert 'breaks its limit' in future.result().message
    assert not here.plans


def test_the_way_back_is_planned_from_where_the_arm_stands_and_then_the_plan_comes_again(cell):
    here = cell()
    answer = here.way_back((0.0, 0.0, 0.0, 0.0, 0.004, 0.0))
    here.until(lambda: len(here.plans) == 2)
    first, back = (plan_from_message(message) for message in here.plans)
    assert answer.success and answer.message == back.plan_hash
    assert back.signal == 'approach'
    assert back.position[-1] == pytest.approx(first.start_position, abs=1e-9)
    assert back.position[0] - first.start_position == pytest.approx([0, 0, 0, 0, 0.004, 0])
    # At the start of the plan the same question gives the plan.
    assert here.way_back((0.0, 0.0, 0.0, 0.001, 0.0, 0.0)).message == first.plan_hash
    here.until(lambda: len(here.plans) == 3)
    assert here.plans[-1].plan_hash == first.plan_hash


def test_a_way_back_is_refused_with_the_reason(cell):
    here = cell()
    assert 'too far' in here.way_back((0.0, 0.0, 0.0, 0.0, 0.1, 0.0)).message
    answer = here.way_back()
    assert not answer.success
    assert 'nobody tells where the arm stands' in answer.message and 'jog' in answer.message
    assert len(here.plans) == 1


def identified(std_hz):
    shape = [1.0, 0.5]
    mode = Mode(frequency_hz=20.0, frequency_std_hz=std_hz, damping_ratio=0.02)
    mode.damping_ratio_std = 0.0005
    mode.shape_real, mode.shape_imag = shape, [0.0, 0.0]
    return ModalParameters(channel_names=['a.x', 'a.y'], modes=[mode], method='ssi_cov')


def test_closed_loop_plans_on_until_the_target_is_met(cell):
    here = cell(closed_loop=True, longest_window_s=16.0)
    here.until(lambda: here.plans)
    here.modes.publish(identified(std_hz=0.2))
    here.until(lambda: len(here.plans) == 2)
    assert here.plans[1].duration_s == 8.0
    assert here.plans[1].seed == 2
    here.modes.publish(identified(std_hz=0.01))
    here.until(lambda: here.planner.finished)
    assert len(here.plans) == 2


def test_bad_modal_parameters_are_counted_not_used(cell):
    here = cell(closed_loop=True)
    here.until(lambda: here.plans)
    message = identified(std_hz=0.2)
    message.modes[0].shape_real = [1.0]
    here.modes.publish(message)
    here.until(lambda: here.planner.n_bad_messages == 1)
    assert len(here.plans) == 1


def test_tampered_messages_are_refused_by_field(cell):
    here = cell()
    here.until(lambda: here.plans)
    message = here.plans[0]
    for field, value, word in (
        ('n_samples', message.n_samples + 1, 'position'),
        # Before anything is made of as many numbers.
        ('n_samples', 1_000_000, 'n_samples: too long'),
        ('sample_period_s', 1.0, 'duration_s: too long'),
        ('peak_point_speed', 0.5, 'plan_hash'),
        ('joint_names', ['a'] * 1000, 'joint_names'),
        ('signal', 'sweep', 'signal'),
    ):
        kept = getattr(message, field)
        setattr(message, field, value)
        with pytest.raises(MessageError, match=word):
            plan_from_message(message)
        setattr(message, field, kept)
    velocity = message.velocity[600]
    message.velocity[600] = float('nan')
    with pytest.raises(MessageError, match='velocity: not finite'):
        plan_from_message(message)
    message.velocity[600] = velocity
    plan_from_message(message)


def test_what_a_map_predicts_at_the_start_is_planned_for(cell):
    own = cell(signal='band_limited_noise', require_full_rank=False, acceleration_rms=0.2)
    publisher = own.user.create_publisher(PredictedModes, '/modal_map/predicted_modes', LATCHED)
    own.until(lambda: own.plans)
    plain = plan_from_message(own.plans[-1])
    model, channels = own.planner.model, own.planner.layout.channels
    modes = model.modes(plain.start_position, channels)
    message = PredictedModes(
        known=True,
        joint_names=[*reversed(model.joint_names)],
        joint_positions=plain.start_position[::-1].tolist(),
        channel_names=[channel.name for channel in channels],
    )
    for at in range(4):
        hz = 1.07 * modes.frequency_hz[at]
        mode = Mode(id=at + 1, frequency_hz=hz, frequency_std_hz=0.1, damping_ratio=0.03)
        mode.shape_real = modes.channel_shapes[:, at].tolist()
        message.modes.append(mode)
    publisher.publish(message)
    own.until(lambda: own.planner.expected is not None)
    own.client.call_async(Trigger.Request())
    own.until(lambda: len(own.plans) > 1)
    told = plan_from_message(own.plans[-1])
    expected = 1.07 * modes.frequency_hz[:4]
    assert told.mode_frequency_hz[:4] == pytest.approx(expected, rel=1e-4)
    assert plain.mode_frequency_hz[:4] == pytest.approx(modes.frequency_hz[:4], rel=1e-4)
    # Of another place, or of no modes: those of the model.
    for changes in ({'joint_positions': [0.5] * 6}, {'known': False}):
        for name, value in changes.items():
            setattr(message, name, value)
        seen = own.planner.expected
        publisher.publish(message)
        own.until(lambda seen=seen: own.planner.expected is not seen)
        count = len(own.plans)
        own.client.call_async(Trigger.Request())
        own.until(lambda count=count: len(own.plans) > count)
        again = plan_from_message(own.plans[-1])
        assert again.plan_hash == plain.plan_hash
    message.known = True
    message.modes[0].frequency_hz = float('nan')
    message.joint_positions = plain.start_position[::-1].tolist()
    publisher.publish(message)
    own.until(lambda: own.planner.n_bad_messages == 1)
