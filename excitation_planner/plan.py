"""The plan: frozen, seeded, hashed; what a person releases is what is played."""

from dataclasses import dataclass, field, fields, replace
import hashlib
import math
import struct

import numpy as np
from numpy.typing import NDArray

from excitation_planner.forecast import PlanPrediction
from excitation_planner.motion import CONSISTENT_RAD, Trajectory
from excitation_planner.signals import LONGEST_S, MOST_SAMPLES, SIGNALS
from modal_core.errors import PlanError

Array = NDArray[np.float64]
CANONICAL_HEADER = b'excitation plan 1\n'
# Predicted figures are rounded so that the last bits of a library do not reach the hash.
SIGNIFICANT = 6
# No arm turns so far [rad] or so fast [rad/s], and no plan is sampled so densely or coarsely.
LARGEST = 1e4
SHORTEST_PERIOD_S, LONGEST_PERIOD_S = 1e-5, 10.0
PER_JOINT = ('start_position', 'position_range', 'peak_velocity', 'peak_acceleration')
PER_MODE = ('mode_frequency_hz', 'mode_frequency_sensitivity', 'mode_signal_to_noise_db')


@dataclass(frozen=True, slots=True, eq=False)
class ExcitationPlan:
    """One plan of self-excitation; the fields of oma_msgs/ExcitationPlan and nothing hidden.

    Parameters
    ----------
    seed : int
        Of every random number in the plan.
    robot_name, signal : str
        Robot; one of ``SIGNALS``.
    joint_names : tuple of str
        Serial joints, one per column.
    start_position, position_range, peak_velocity, peak_acceleration : (n_joints,) array
        Pose the plan starts at and, but for an approach, returns to, and the envelope
        [rad, rad, rad/s, rad/s²].
    peak_point_speed : float [m/s]
        Of the fastest point of the arm.
    duration_s : float [s]
        Of the trajectory.
    band_low_hz, band_high_hz : float [Hz]
        Where the predicted acceleration density is within 10 dB of its maximum.
    torque_projection_rank : int
        Rank of D(τ), Eq. (20).
    mode_frequency_hz, mode_frequency_sensitivity, mode_signal_to_noise_db : (n_modes,) array
        Predicted modes up to the highest frequency of interest; largest relative change of each
        over the range; predicted signal to noise at its best sensor.
    sample_period_s : float [s]
        Of the trajectory.
    position, velocity : (n_samples, n_joints) array [rad], [rad/s]
        The trajectory.
    plan_hash : str
        SHA-256 over :func:`canonical_bytes`, hexadecimal; empty before :func:`sealed`.
    prediction : PlanPrediction or None
        What the planner foresaw in more detail than the message carries; not hashed.
    """

    seed: int
    robot_name: str
    signal: str
    joint_names: tuple[str, ...]
    start_position: Array
    position_range: Array
    peak_velocity: Array
    peak_acceleration: Array
    peak_point_speed: float
    duration_s: float
    band_low_hz: float
    band_high_hz: float
    torque_projection_rank: int
    mode_frequency_hz: Array
    mode_frequency_sensitivity: Array
    mode_signal_to_noise_db: Array
    sample_period_s: float
    position: Array
    velocity: Array
    plan_hash: str = ''
    prediction: PlanPrediction | None = field(default=None, repr=False)

    @property
    def n_samples(self) -> int:
        """Rows of the trajectory."""
        return len(self.position)

    @property
    def trajectory(self) -> Trajectory:
        """The motion, also between the samples."""
        return Trajectory(self.sample_period_s, self.position, self.velocity)


UNHASHED = ('plan_hash', 'prediction')


def canonical_bytes(plan: ExcitationPlan) -> bytes:
    """Return the bytes the hash is made of.

    Field after field in the order of the message: the field's name, then an unsigned 64-bit
    count, then the content; text as UTF-8, whole numbers as unsigned 64-bit, real numbers as
    IEEE 754 doubles, all little-endian and row-major.  Everything is in the message.
    """
    parts = [CANONICAL_HEADER]
    for item in fields(plan):
        if item.name not in UNHASHED:
            parts += [_text(item.name), _encoded(getattr(plan, item.name))]
    return b''.join(parts)


def plan_hash(plan: ExcitationPlan) -> str:
    """Return the SHA-256 of the plan's canonical bytes, recomputed from its fields."""
    return hashlib.sha256(canonical_bytes(plan)).hexdigest()


def sealed(plan: ExcitationPlan) -> ExcitationPlan:
    """Return the plan with its hash and with arrays that cannot be written to."""
    for item in fields(plan):
        value = getattr(plan, item.name)
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return replace(plan, plan_hash=plan_hash(plan))


def check_size(n_samples: int, sample_period_s: float) -> None:
    """Refuse a plan that is too long, before anything is made of it.

    Raises
    ------
    PlanError
        Too many samples, or samples for too long a time.
    """
    if n_samples > MOST_SAMPLES:
        raise PlanError(
            'too long',
            where='n_samples',
            found=n_samples,
            expected=f'<= {MOST_SAMPLES}',
            advice='plan several shorter motions',
        )
    # A whole number of periods ends a rounding error away from it.
    duration_s = (n_samples - 1) * sample_period_s
    if duration_s > LONGEST_S * (1.0 + 1e-9):
        raise PlanError(
            'too long',
            where='duration_s',
            found=f'{duration_s:.6g} s',
            expected=f'<= {LONGEST_S:g} s',
            advice='plan several shorter motions',
        )


def check_plan(plan: ExcitationPlan) -> None:
    """Refuse a plan that contradicts itself; for plans that come from elsewhere.

    Raises
    ------
    PlanError
        Naming the field: too long, wrong length, not finite, unknown signal, position and
        velocity that disagree, not at rest at the ends, or a hash that is not the plan's.
    """
    _check_shapes(plan)
    check_size(plan.n_samples, plan.sample_period_s)
    trajectory = plan.trajectory
    if plan.velocity[0].any() or plan.velocity[-1].any():
        raise PlanError('not at rest at its ends', where='velocity')
    difference = trajectory.inconsistency_rad()
    if difference > CONSISTENT_RAD:
        raise PlanError(
            'position is not the integral of velocity',
            where='position',
            found=f'{difference:.3g} rad apart',
            expected=f'<= {CONSISTENT_RAD} rad',
        )
    if not np.array_equal(plan.start_position, plan.position[0]):
        raise PlanError('is not the first row of position', where='start_position')
    if not math.isclose(plan.duration_s, trajectory.duration_s, rel_tol=1e-9):
        raise PlanError(
            'does not fit the samples',
            where='duration_s',
            found=plan.duration_s,
            expected=trajectory.duration_s,
        )
    actual = plan_hash(plan)
    if plan.plan_hash != actual:
        raise PlanError(
            'is not the hash of this plan',
            where='plan_hash',
            found=plan.plan_hash[:16] or 'nothing',
            expected=actual[:16],
            advice='the plan was changed after it was made',
        )


def rounded(values: object) -> Array:
    """Round to significant digits; adding zero turns -0 into 0."""
    numbers = np.asarray(values, dtype=float)
    with np.errstate(divide='ignore'):
        magnitude = np.where(numbers != 0.0, np.floor(np.log10(np.abs(numbers))), 0.0)
    scale = 10.0 ** (SIGNIFICANT - 1 - magnitude)
    return np.asarray(np.round(numbers * scale) / scale + 0.0)


def _check_shapes(plan: ExcitationPlan) -> None:
    n_joints = len(plan.joint_names)
    if plan.signal not in SIGNALS:
        raise PlanError(
            'unknown signal', where='signal', found=plan.signal, expected=' or '.join(SIGNALS)
        )
    if n_joints == 0 or len(set(plan.joint_names)) != n_joints:
        raise PlanError('no joints or one named twice', where='joint_names')
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(PER_JOINT, (n_joints,))
    shapes |= {name: (len(plan.mode_frequency_hz),) for name in PER_MODE}
    shapes |= dict.fromkeys(('position', 'velocity'), (plan.n_samples, n_joints))
    for name, shape in shapes.items():
        value = getattr(plan, name)
        if value.shape != shape:
            raise PlanError('wrong length', where=name, found=value.shape, expected=shape)
        if not np.all(np.isfinite(value)):
            raise PlanError('not finite', where=name)
    if plan.n_samples < 2:
        raise PlanError('too few samples', where='position', found=plan.n_samples)
    scalars = ('peak_point_speed', 'duration_s', 'band_low_hz', 'band_high_hz', 'sample_period_s')
    for name in scalars:
        if not math.isfinite(getattr(plan, name)):
            raise PlanError('not finite', where=name)
    if not SHORTEST_PERIOD_S <= plan.sample_period_s <= LONGEST_PERIOD_S:
        raise PlanError(
            'out of range',
            where='sample_period_s',
            found=plan.sample_period_s,
            expected=f'{SHORTEST_PERIOD_S:g} s..{LONGEST_PERIOD_S:g} s',
        )
    for name in ('position', 'velocity'):
        largest = float(np.max(np.abs(getattr(plan, name))))
        if largest > LARGEST:
            raise PlanError('out of range', where=name, found=largest, expected=f'<= {LARGEST:g}')


def _encoded(value: object) -> bytes:
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, int):
        return struct.pack('<QQ', 1, value)
    if isinstance(value, tuple):
        return struct.pack('<Q', len(value)) + b''.join(_text(item) for item in value)
    numbers = np.ascontiguousarray(value, dtype='<f8')
    return struct.pack('<Q', numbers.size) + numbers.tobytes()


def _text(value: str) -> bytes:
    data = value.encode()
    return struct.pack('<Q', len(data)) + data
