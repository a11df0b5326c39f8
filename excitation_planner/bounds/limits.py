"""A plan keeps every limit over its whole length, or it is refused whole; nothing is clipped.

Everything is looked at on a grid ten times as fine as the samples, along the spline a player
follows.  What can happen between two points of that grid is bounded by the next derivative, and
counted as if it happened.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.bounds.self_collision import proven_clearance
from excitation_planner.motion import MotionOnGrid, Trajectory
from excitation_planner.signals import HIGHEST_PATH_HZ
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
FINER = 10
# Samples looked at together, so that memory does not grow with the plan.
CHUNK = 1000
# Speed no point of the arm may exceed while a person may be near (ISO 10218-1, reduced speed).
REDUCED_SPEED_M_S = 0.25
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True, slots=True)
class Quantity:
    """One limited quantity over the fine grid.

    Parameters
    ----------
    name, unit : str
        For messages; angles are shown in degrees.
    owners : tuple of str
        Joint, link or point, one per column.
    value : (n_times, n_columns) array
        What the motion needs.
    low, high : (n_columns,) array
        What it may.
    """

    name: str
    unit: str
    owners: tuple[str, ...]
    value: Array
    low: Array
    high: Array


@dataclass(frozen=True, slots=True)
class LimitUse:
    """The closest a motion comes to one kind of limit.

    Parameters
    ----------
    name, unit : str
        Kind of limit.
    owner : str
        Joint, link or point.
    time_s : float [s]
        When.
    value, limit : float
        What is used and what may be.
    fraction : float
        Use over limit; for a range the distance from its middle over its half.
    """

    name: str
    unit: str
    owner: str
    time_s: float
    value: float
    limit: float
    fraction: float


@dataclass(frozen=True, slots=True)
class Envelope:
    """What a motion uses of every limit.

    Parameters
    ----------
    uses : tuple of LimitUse
        One per kind of limit.
    peak_point_speed_m_s : float [m/s]
        Of the fastest point of the arm.
    clearance_m : float [m]
        Smallest distance between links that are not neighbours.
    peak_velocity, peak_acceleration : (n_joints,) array [rad/s], [rad/s²]
        Of the serial joints, also between the samples.
    """

    uses: tuple[LimitUse, ...]
    peak_point_speed_m_s: float
    clearance_m: float
    peak_velocity: Array
    peak_acceleration: Array

    @property
    def worst(self) -> LimitUse:
        """The limit that is used most."""
        return max(self.uses, key=lambda use: use.fraction)


@dataclass(frozen=True)
class PlanLimits:
    """Everything a plan must keep.

    Parameters
    ----------
    model : FlexibleJointModel
        Arm, axis limits and drive torques.
    point_speed_m_s : float [m/s]
        For any point of the arm.
    box_m : two corners [m] or None
        In the base frame; all moving links stay inside.
    clearance_m : float [m]
        Smallest distance between links that are not neighbours.
    jerk_limited : bool
        False for rectangular pulses, whose jerk has no bound by nature.
    guided : bool
        True for a motion sent as position and speed references: the controller's path planner and
        its jerk limit are not in the way, and the jerk may be what full acceleration at the
        highest frequency of the path needs.
    """

    model: FlexibleJointModel
    point_speed_m_s: float = REDUCED_SPEED_M_S
    box_m: Box | None = None
    clearance_m: float = 0.01
    jerk_limited: bool = True
    guided: bool = False

    @property
    def jerk(self) -> Array:
        """Largest jerk of each axis, (n_joints,) [rad/s³]."""
        if not self.jerk_limited:
            return np.full(len(self.model.joint_names), np.inf)
        if self.guided:
            return np.asarray(2.0 * np.pi * HIGHEST_PATH_HZ * self.model.limits.acceleration)
        return self.model.limits.jerk


def check_limits(trajectory: Trajectory, limits: PlanLimits) -> Envelope:
    """Refuse a motion that breaks a limit anywhere; return what it uses otherwise.

    Raises
    ------
    PlanError
        Limit, joint or link, time, value and limit, of the earliest stretch that breaks one.
    """
    uses: dict[str, LimitUse] = {}
    clearance_m = float('inf')
    peaks = np.zeros((2, trajectory.velocity.shape[1]))
    for motion in trajectory.pieces(FINER, CHUNK):
        for quantity in _quantities(motion, limits):
            use = _use(quantity, motion.time_s)
            if use.fraction > 1.0:
                raise _refusal(use)
            if use.name not in uses or use.fraction > uses[use.name].fraction:
                uses[use.name] = use
        if limits.box_m is not None:
            _check_box(motion, limits, uses['point speed'].value)
        clearance_m = min(clearance_m, _check_clearance(motion, limits))
        found = [np.max(np.abs(x), axis=0) for x in (motion.velocity, motion.acceleration)]
        peaks = np.maximum(peaks, found)
    return Envelope(tuple(uses.values()), uses['point speed'].value, clearance_m, *peaks)


def _quantities(motion: MotionOnGrid, limits: PlanLimits) -> Iterator[Quantity]:
    axis_limits = limits.model.limits
    names = axis_limits.axis_names
    to_axis = axis_limits.axes.to_controller
    axis, joint = to_axis(motion.position), motion.position
    low, high = axis_limits.controller_low, axis_limits.controller_high
    yield Quantity('axis range', 'deg', names, _outward(axis), low, high)
    low, high = axis_limits.position_low, axis_limits.position_high
    yield Quantity('coupled range', 'deg', axis_limits.joint_names, _outward(joint), low, high)
    for name, value, unit, high in (
        ('velocity', motion.velocity, 'deg/s', axis_limits.velocity),
        ('acceleration', motion.acceleration, 'deg/s²', axis_limits.acceleration),
        ('jerk', motion.jerk, 'deg/s³', limits.jerk),
    ):
        # The jerk is a broken line with its corners on the grid: it needs no bound between.
        axis = to_axis(value)
        yield Quantity(name, unit, names, axis if name == 'jerk' else _outward(axis), -high, high)
    torque = limits.model.drive_torque(motion.position, motion.velocity, motion.acceleration)
    effort = axis_limits.effort
    yield Quantity('drive torque', 'N m', names, _outward(torque), -effort, effort)
    yield _point_speed(motion, limits)


def _point_speed(motion: MotionOnGrid, limits: PlanLimits) -> Quantity:
    fastest = limits.model.geometry.fastest_point(motion.position, motion.velocity)
    speed = _outward(fastest.speed_m_s[:, None])
    high = np.array([limits.point_speed_m_s])
    link = fastest.link[int(np.argmax(speed))]
    return Quantity('point speed', 'm/s', (link,), speed, -high, high)


def _check_box(motion: MotionOnGrid, limits: PlanLimits, speed_m_s: float) -> None:
    """Refuse a motion that leaves the Cartesian box; time by halving."""
    assert limits.box_m is not None  # noqa: S101 - narrowed by the caller
    # Between two grid points nothing goes farther than half a step at the highest speed.
    slack = 0.5 * speed_m_s * (motion.time_s[1] - motion.time_s[0])
    low, high = np.array(limits.box_m[0]) + slack, np.array(limits.box_m[1]) - slack

    def excess(first: int, last: int) -> Array:
        extent = limits.model.geometry.moving_extent(motion.position[first:last])
        return np.stack([low - extent[0], extent[1] - high])

    first, last = 0, len(motion.time_s)
    if np.max(excess(first, last)) <= 0.0:
        return
    while last - first > 1:
        middle = (first + last) // 2
        first, last = (first, middle) if np.max(excess(first, middle)) > 0.0 else (middle, last)
    beyond = excess(first, last)
    side, axis = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
    limit = limits.box_m[side][axis]
    value = limit + (beyond[side, axis] if side else -beyond[side, axis])
    raise PlanError(
        f'the arm leaves the box in {"xyz"[axis]}',
        where=f'plan at {motion.time_s[first]:.3f} s',
        found=f'{value:.4f} m',
        expected=f'{"<=" if side else ">="} {limit:.4f} m',
    )


def _check_clearance(motion: MotionOnGrid, limits: PlanLimits) -> float:
    closest = proven_clearance(limits.model, motion.position, limits.clearance_m)
    if closest is None:
        return float('inf')
    if closest.distance_m < limits.clearance_m:
        raise PlanError(
            f'links {closest.first} and {closest.second} come too close',
            where=f'plan at {motion.time_s[closest.sample]:.3f} s',
            found=f'{1e3 * closest.distance_m:.1f} mm',
            expected=f'>= {1e3 * limits.clearance_m:.1f} mm',
        )
    return closest.distance_m


def _outward(value: Array) -> Array:
    """Push values away from zero by what the curve can do between two grid points.

    A smooth curve leaves its chord by at most step²/8 times its second derivative; the second
    difference stands for step² times that derivative.
    """
    second = np.zeros_like(value)
    second[1:-1] = np.abs(value[2:] - 2.0 * value[1:-1] + value[:-2])
    second[:-1] = np.maximum(second[:-1], second[1:])
    return np.asarray(value + np.sign(value) * second / 8.0)


def _use(quantity: Quantity, time_s: Array) -> LimitUse:
    with np.errstate(invalid='ignore', divide='ignore'):
        middle = 0.5 * (quantity.high + quantity.low)
        half = 0.5 * (quantity.high - quantity.low)
        fraction = np.abs(quantity.value - middle) / half
    # An infinite limit is never used up; an empty range always is.
    fraction = np.where(np.isinf(quantity.high) & np.isinf(quantity.low), 0.0, fraction)
    fraction = np.where(half > 0.0, fraction, np.inf)
    row, column = np.unravel_index(int(np.argmax(fraction)), fraction.shape)
    value = float(quantity.value[row, column])
    above = value >= middle[column] if np.isfinite(middle[column]) else value >= 0.0
    limit = quantity.high[column] if above else quantity.low[column]
    return LimitUse(
        name=quantity.name,
        unit=quantity.unit,
        owner=quantity.owners[column],
        time_s=float(time_s[row]),
        value=value,
        limit=float(limit),
        fraction=float(fraction[row, column]),
    )


def _refusal(use: LimitUse) -> PlanError:
    degrees = use.unit.startswith('deg')
    value, limit = (np.rad2deg(x) if degrees else x for x in (use.value, use.limit))
    return PlanError(
        f'{use.name} of {use.owner} breaks its limit',
        where=f'plan at {use.time_s:.3f} s',
        found=f'{_apart(value, limit)} {use.unit}',
        expected=f'{"<=" if value > limit else ">="} {limit:.4g} {use.unit}',
        advice='lower the amplitude, slow the moves or choose another pose',
    )


def _apart(value: float, limit: float) -> str:
    """Return a value with as many digits as tell it from a limit, four at least."""
    texts = (f'{value:.{digits}g}' for digits in range(4, 17))
    return next((text for text in texts if float(text) != float(f'{limit:.4g}')), repr(value))
