"""Plans to and from ROS messages; everything received is validated before it is used."""

from array import array
from collections.abc import Sequence
from typing import Any

from builtin_interfaces.msg import Duration
import numpy as np
from numpy.typing import NDArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from excitation_planner.forecast import ExpectedModes
from excitation_planner.plan import check_plan, check_size, ExcitationPlan
from modal_core.errors import MessageError, PlanError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode, MODE_KEYS, ModeSet
from oma_msgs.msg import ExcitationPlan as PlanMessage
from oma_msgs.msg import ModalParameters, PredictedModes

SCALARS = (
    'plan_hash',
    'seed',
    'robot_name',
    'signal',
    'peak_point_speed',
    'duration_s',
    'band_low_hz',
    'band_high_hz',
    'torque_projection_rank',
    'sample_period_s',
)
ARRAYS = (
    'start_position',
    'position_range',
    'peak_velocity',
    'peak_acceleration',
    'mode_frequency_hz',
    'mode_frequency_sensitivity',
    'mode_signal_to_noise_db',
)
TABLES = ('position', 'velocity')
MOST_JOINTS = 64
MOST_MODES = 500


def plan_to_message(plan: ExcitationPlan) -> PlanMessage:
    """Return the message of a plan; the header is the publisher's."""
    message = PlanMessage(joint_names=list(plan.joint_names), n_samples=plan.n_samples)
    for name in SCALARS:
        setattr(message, name, getattr(plan, name))
    for name in (*ARRAYS, *TABLES):
        numbers = np.ascontiguousarray(getattr(plan, name), dtype=float)
        setattr(message, name, array('d', numbers.tobytes()))
    return message


def plan_from_message(message: PlanMessage) -> ExcitationPlan:
    """Return the plan of a message, its hash recomputed and compared.

    Raises
    ------
    MessageError
        Naming the field that is too long, does not fit the others, is not finite, or a hash that
        is not the plan's.
    """
    n_joints, n_samples = len(message.joint_names), message.n_samples
    for name, found, most in (
        ('joint_names', n_joints, MOST_JOINTS),
        ('mode_frequency_hz', len(message.mode_frequency_hz), MOST_MODES),
    ):
        if found > most:
            raise MessageError('too long', where=name, found=found, expected=f'<= {most}')
    try:
        check_size(n_samples, message.sample_period_s)
    except PlanError as error:
        raise _refused(error) from error
    for name in TABLES:
        found = len(getattr(message, name))
        if found != n_joints * n_samples:
            raise MessageError(
                'wrong length',
                where=name,
                found=found,
                expected=f'{n_samples} samples x {n_joints} joints',
            )
    fields: dict[str, Any] = {name: getattr(message, name) for name in SCALARS}
    for name in (*ARRAYS, *TABLES):
        fields[name] = _numbers(getattr(message, name))
    for name in TABLES:
        fields[name] = fields[name].reshape(n_samples, n_joints)
    plan = ExcitationPlan(joint_names=tuple(message.joint_names), **fields)
    try:
        check_plan(plan)
    except PlanError as error:
        raise _refused(error) from error
    return plan


def trajectory_message(plan: ExcitationPlan) -> JointTrajectory:
    """Return the plan as a trajectory for controllers that take one."""
    points = []
    acceleration = plan.trajectory.acceleration
    for row in range(plan.n_samples):
        time_ns = round(row * plan.sample_period_s * NANOSECONDS_PER_SECOND)
        points.append(
            JointTrajectoryPoint(
                positions=plan.position[row].tolist(),
                velocities=plan.velocity[row].tolist(),
                accelerations=acceleration[row].tolist(),
                time_from_start=Duration(
                    sec=time_ns // NANOSECONDS_PER_SECOND,
                    nanosec=time_ns % NANOSECONDS_PER_SECOND,
                ),
            )
        )
    return JointTrajectory(joint_names=list(plan.joint_names), points=points)


def modes_from_message(message: ModalParameters) -> ModeSet:
    """Return the identified modes of a window, harmonics left out.

    Raises
    ------
    MessageError
        A frequency, damping ratio or shape that cannot be.
    """
    modes = []
    for index, mode in enumerate(message.modes):
        where = f'ModalParameters.modes[{index}]'
        values = {key: getattr(mode, key) for key in MODE_KEYS if hasattr(mode, key)}
        try:
            found = Mode.from_values(values, len(message.channel_names))
        except ValueError as error:
            raise MessageError('not a mode', where=where, found=error) from error
        if not np.isfinite(found.shape).all():
            raise MessageError('shape is not finite', where=where)
        if not found.harmonic:
            modes.append(found)
    ordered = sorted(modes, key=lambda mode: mode.frequency_hz)
    return ModeSet(tuple(ordered), tuple(message.channel_names), message.method)


def expected_from_message(
    message: PredictedModes, joint_names: Sequence[str]
) -> ExpectedModes | None:
    """Return the modes that a map expects; None where it tells of none, or of another arm.

    Parameters
    ----------
    message : PredictedModes
        Of a map.
    joint_names : sequence of str
        Serial joints, in the order wanted.

    Raises
    ------
    MessageError
        A length or a number that cannot be.
    """
    at = dict(zip(message.joint_names, message.joint_positions, strict=False))
    if not message.known or not set(joint_names) <= set(at):
        return None
    modes, n_channels = message.modes[: MOST_MODES + 1], len(message.channel_names)
    if len(modes) > MOST_MODES:
        raise MessageError('too long', where='PredictedModes.modes', expected=f'<= {MOST_MODES}')
    if any(len(mode.shape_real) != n_channels for mode in modes):
        raise MessageError('wrong length', where='PredictedModes.modes', expected=n_channels)
    columns = ('frequency_hz', 'frequency_std_hz', 'damping_ratio')
    numbers = [np.array([getattr(mode, name) for mode in modes]) for name in columns]
    shapes = np.array([mode.shape_real for mode in modes]).reshape(len(modes), n_channels).T
    joints = np.array([at[name] for name in joint_names])
    if not all(np.isfinite(part).all() for part in (*numbers, shapes, joints)):
        raise MessageError('not finite', where='PredictedModes')
    if any((part <= 0.0).any() for part in numbers):
        raise MessageError('not positive', where='PredictedModes.modes')
    names = tuple(message.channel_names)
    return ExpectedModes(joints, numbers[0], numbers[1], numbers[2], shapes, names)


def _refused(error: PlanError) -> MessageError:
    return MessageError(
        error.what,
        where=f'ExcitationPlan.{error.where}',
        found=error.found,
        expected=error.expected,
        advice=error.advice,
    )


def _numbers(values: object) -> NDArray[np.float64]:
    return np.array(values, dtype=float)
