"""How far the joints may move around a pose before a natural frequency changes too much.

The range is a box of controller axes, the angles an operator sees.  It is found by walking
outwards along many rays until the tolerance is used up, and then proven by fresh poses inside.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from excitation_planner.pose_range.sensitivity import FrequencyChange
from modal_core.errors import PlanError
from structural_model.description import RobotLimits

Array = NDArray[np.float64]
LARGEST_RAD = np.deg2rad(30.0)
SMALLEST_RAD = np.deg2rad(0.001)
N_DIRECTIONS = 64
N_PROOF = 256
BISECTIONS = 8
# Each failed proof shrinks the box by a little more than what failed.
SHRINK = 0.98


@dataclass(frozen=True, slots=True)
class AllowedRange:
    """The largest box found, and its proof.

    Parameters
    ----------
    half_range : (n_joints,) array [rad]
        Each controller axis may move this far either way.
    tolerance : float
        What was asked.
    largest_change : float
        Largest relative change of any mode over the proof.
    worst_mode : int
        Index of that mode.
    n_proof : int
        Poses inside the box at which all modes kept the tolerance.
    limited_by : str
        ``frequency``, ``joint range`` or ``search range``.
    """

    half_range: Array
    tolerance: float
    largest_change: float
    worst_mode: int
    n_proof: int
    limited_by: str


def allowed_range(
    change: FrequencyChange,
    q: Array,
    weights: Array,
    tolerance: float,
    limits: RobotLimits,
    generator: np.random.Generator,
) -> AllowedRange:
    """Return the largest box around a pose in which no frequency changes by more than asked.

    Parameters
    ----------
    change : FrequencyChange
        From the model or from shapes, see :mod:`excitation_planner.pose_range.sensitivity`.
    q : (n_joints,) array [rad]
        Centre, serial joints.
    weights : (n_joints,) array
        Proportions of the box, largest 1; 0 keeps an axis still.
    tolerance : float
        Largest relative change of any natural frequency.
    limits : RobotLimits
        The box stays inside them.
    generator : numpy.random.Generator
        For directions and proof.

    Raises
    ------
    PlanError
        Even the smallest range breaks the tolerance.
    """
    room = min(LARGEST_RAD, _room(q, weights, limits))
    radius, limited_by = room, 'joint range' if room < LARGEST_RAD else 'search range'
    for direction in _directions(weights, generator):
        reached = _walk(change, q, limits.axes.to_serial(direction), tolerance, radius)
        if reached < radius:
            radius, limited_by = reached, 'frequency'
    while radius >= SMALLEST_RAD:
        unit = weights * _proof_points(weights, generator)
        inside = q + radius * limits.axes.to_serial(unit)
        changes = np.array([np.abs(change(pose)) for pose in inside])
        largest = float(np.max(changes)) if changes.size else 0.0
        if largest <= tolerance:
            worst = int(np.argmax(np.max(changes, axis=0))) if changes.size else -1
            return AllowedRange(
                radius * weights, tolerance, largest, worst, len(inside), limited_by
            )
        radius, limited_by = radius * SHRINK * tolerance / largest, 'frequency'
    raise _no_range(change, q, limits.axes.to_serial(weights * _axes(weights)), tolerance)


def largest_change(
    change: FrequencyChange, q: Array, low: Array, high: Array, limits: RobotLimits
) -> Array:
    """Return the largest relative change of each mode over a box, at corners and face centres.

    Parameters
    ----------
    change : FrequencyChange
        Against the pose ``q``.
    q : (n_joints,) array [rad]
        Centre, serial joints.
    low, high : (n_joints,) array [rad]
        Corners of the box, controller axes.
    limits : RobotLimits
        Between the two.
    """
    unit = np.concatenate([_corners(high - low), _axes(high - low)])
    centre = limits.axes.to_controller(q)
    poses = np.where(unit > 0.0, high, np.where(unit < 0.0, low, centre))
    changes = [change(pose) for pose in limits.axes.to_serial(poses)]
    return np.asarray(np.max(np.abs(changes), axis=0))


def is_allowed(
    change: FrequencyChange, q: Array, half_range: Array, tolerance: float, limits: RobotLimits
) -> bool:
    """Return whether a box keeps the tolerance and the joint ranges, at corners and face centres.

    Parameters
    ----------
    change, q, tolerance, limits
        As for :func:`allowed_range`.
    half_range : (n_joints,) array [rad]
        Of the controller axes.
    """
    if _room(q, half_range, limits) < 1.0:
        return False
    centre = limits.axes.to_controller(q)
    changes = largest_change(change, q, centre - half_range, centre + half_range, limits)
    return not changes.size or float(np.max(changes)) <= tolerance


def _room(q: Array, weights: Array, limits: RobotLimits) -> float:
    """Return the radius at which the worst corner of the box meets a joint range."""
    room = np.inf
    for matrix, angle, low, high in (
        (
            np.eye(len(q)),
            limits.axes.to_controller(q),
            limits.controller_low,
            limits.controller_high,
        ),
        (np.linalg.inv(limits.axes.matrix), q, limits.position_low, limits.position_high),
    ):
        spread = np.abs(matrix) @ weights
        distance = np.minimum(high - angle, angle - low)
        with np.errstate(divide='ignore', invalid='ignore'):
            room = min(room, float(np.min(np.where(spread > 0.0, distance / spread, np.inf))))
    return room


def _directions(weights: Array, generator: np.random.Generator) -> Array:
    """Return rays to corners, face centres and random points of the unit box, (n, n_joints)."""
    random = _sobol(weights, N_DIRECTIONS, generator)
    random /= np.maximum(np.max(np.abs(random), axis=1, keepdims=True), 1e-12)
    return np.concatenate([_axes(weights), _corners(weights), random]) * weights


def _proof_points(weights: Array, generator: np.random.Generator) -> Array:
    return np.concatenate([_corners(weights), _sobol(weights, N_PROOF, generator)])


def _sobol(weights: Array, count: int, generator: np.random.Generator) -> Array:
    """Return points spread evenly in the box from -1 to 1, still joints at 0."""
    moving = np.flatnonzero(weights)
    points = np.zeros((count, len(weights)))
    # Shifted by our own random numbers: scipy's scrambling differs between its versions.
    sequence = qmc.Sobol(len(moving), scramble=False).random(count)
    points[:, moving] = 2.0 * ((sequence + generator.random(len(moving))) % 1.0) - 1.0
    return points


def _corners(weights: Array) -> Array:
    moving = np.flatnonzero(weights)
    corners = np.zeros((2 ** len(moving), len(weights)))
    corners[:, moving] = 2.0 * np.array(list(np.ndindex(*[2] * len(moving)))) - 1.0
    return corners


def _axes(weights: Array) -> Array:
    moving = np.flatnonzero(weights)
    units = np.eye(len(weights))[moving]
    return np.concatenate([units, -units])


def _walk(
    change: FrequencyChange, q: Array, direction: Array, tolerance: float, farthest: float
) -> float:
    """Return the radius at which a ray first uses up the tolerance, at most ``farthest``."""

    def kept(radius: float) -> bool:
        changes = change(q + radius * direction)
        return not changes.size or float(np.max(np.abs(changes))) <= tolerance

    inside, outside = 0.0, farthest / 16.0
    while kept(outside):
        if outside >= farthest:
            return farthest
        inside, outside = outside, min(2.0 * outside, farthest)
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if kept(middle) else (inside, middle)
    return inside


def _no_range(change: FrequencyChange, q: Array, units: Array, tolerance: float) -> PlanError:
    poses = q + SMALLEST_RAD * units
    smallest = float(np.max(np.abs([change(pose) for pose in poses])))
    return PlanError(
        'no joint range meets the tolerance',
        where='frequency_tolerance',
        found=f'{smallest:.3g} already at {np.rad2deg(SMALLEST_RAD):.3f} deg',
        expected=f'<= {tolerance:.3g}',
        advice='raise the tolerance',
    )
