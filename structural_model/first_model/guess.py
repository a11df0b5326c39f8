"""Numbers that a URDF does not give: stiffness from torque, damping, accelerations, a pose."""

from collections.abc import Mapping
import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin
import yaml

from modal_core.errors import ModelError
from structural_model.description import Joint, RigidRobot, shown
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.robot_files import robot_of_files

Array = NDArray[np.float64]
TWIST_RAD = 6e-3
"""Of a drive, gear and casting, under its largest torque: 6.5e-3 is the geometric mean of the six
of the shipped IRB 6660, fitted to published frequencies (2.8e-3 to 12e-3), a factor of 1.6 the
deviation."""
GIVE_M = 1e-4
"""Of a sliding drive under its largest force; assumed."""
TILT_RATIO, CARRIAGE_M = 4.0, 0.3
"""Stiffness of a bearing across over that of its drive, the geometric mean of the twelve of the
same fit (1.1 to 17); how far apart the guides of a carriage are, assumed."""
DAMPING_RATIO, UP_TO = 0.02, 5.0
"""At the lowest mode and at so many times its frequency; robots at rest have 1 to 4 %."""
ACCELERATION_1_S, JERK_1_S = 3.0, 20.0
"""Over the speed, and over the acceleration: as of the shipped arms."""
SPEED_RAD_S, SPEED_M_S = 1.0, 0.25
"""Where a URDF gives none."""
TOLERANCES = {'stiffness': 0.5, 'damping': 0.5}
"""How roughly they are known, as one standard deviation: that of the six twists above."""
POSES, SEED = 200, 0
"""Where inertia and weight are looked at, and a home is looked for."""
SPAN = 0.5
"""Of the evenest torques about three directions that any pose gives: a home has so much;
chosen."""
TOUCHING_M = 0.02
"""Bodies nearer than that at home are said to touch; plans keep half of it; chosen."""
NEAR_END = 0.05
"""Of its range: zero is no home nearer to the end than that; chosen."""


def guessed_model(
    robot: RigidRobot, lowest_hz: float | None, where: str
) -> tuple[FlexibleJointModel, str, tuple[str, ...]]:
    """Return a model of a rigid robot, its ``model.yaml``, and what was guessed, in statements.

    Parameters
    ----------
    robot : RigidRobot
        The arm.
    lowest_hz : float [Hz] or None
        Lowest natural frequency at home, if known.
    where : str
        What to call it in errors.

    Raises
    ------
    ModelError
        The frequency is none, or the numbers contradict each other.
    """
    if lowest_hz is not None and not 0.0 < lowest_hz < math.inf:
        raise ModelError('not a frequency', where=where, found=lowest_hz, expected='above 0 Hz')
    speed = _stated(robot, 'velocity', np.where(_sliding(robot), SPEED_M_S, SPEED_RAD_S))
    needed = _needed(robot, ACCELERATION_1_S * speed)
    effort = _stated(robot, 'effort', needed)
    home = _home(robot, ACCELERATION_1_S * speed)
    sliding = _sliding(robot)
    drive = effort / np.where(sliding, GIVE_M, TWIST_RAD)
    tilt = TILT_RATIO * drive * np.where(sliding, CARRIAGE_M**2, 1.0)
    mapping: dict[str, Any] = {
        'robot_name': robot.name,
        'limits': _limits(robot, speed, effort),
        'poses_controller_deg': {'home': [_rounded(x) for x in shown(home, list(sliding))]},
    }

    def model_of(factor: float, **more: object) -> FlexibleJointModel:
        mapping.update({'joints': _joints(robot, factor * drive, factor * tilt), **more})
        return robot_of_files(robot.text, _text(mapping), where)

    found_hz = _lowest(model_of(1.0), home)
    factor = 1.0
    if lowest_hz is not None:
        factor = (lowest_hz / found_hz) ** 2
        # Weight is stiffness too, and does not grow with the springs.
        factor *= (lowest_hz / _lowest(model_of(factor), home)) ** 2
        found_hz = lowest_hz
    model = model_of(factor, damping=_rayleigh(found_hz), tolerances=TOLERANCES)
    touching = _touching(model, home)
    model = model_of(factor, collision_ignore=[list(pair) for pair in touching])
    return model, _text(mapping), _statements(robot, found_hz, lowest_hz, touching)


def _statements(
    robot: RigidRobot,
    found_hz: float,
    lowest_hz: float | None,
    touching: list[tuple[str, str]],
) -> tuple[str, ...]:
    said = [
        f'stiffness of every drive: it twists by {1e3 * TWIST_RAD:g} mrad under its largest torque'
        if lowest_hz is None
        else 'stiffness of every drive: in proportion to its largest torque',
        f'lowest mode at home {found_hz:.3g} Hz, known to about half its stiffness',
        f'damping ratio {100.0 * DAMPING_RATIO:g} % there and at {UP_TO:g} times the frequency',
        f'acceleration reaches the largest speed in {1.0 / ACCELERATION_1_S:.2g} s',
    ]
    for name, words in (('velocity', 'largest speed'), ('effort', 'largest torque')):
        missing = [joint.name for joint in robot.joints if not _is_given(joint, name)]
        if missing:
            said.append(f'{words} of {", ".join(missing)}: the URDF gives none')
    if touching:
        pairs = ', '.join(' and '.join(pair) for pair in touching)
        said.append(f'may touch, since they do at home: {pairs}')
    return tuple(said)


def _is_given(joint: Joint, name: str) -> bool:
    return 0.0 < float(getattr(joint, name)) < math.inf


def _stated(robot: RigidRobot, name: str, otherwise: Array) -> Array:
    return np.array(
        [
            getattr(joint, name) if _is_given(joint, name) else float(other)
            for joint, other in zip(robot.joints, otherwise, strict=True)
        ]
    )


def _sliding(robot: RigidRobot) -> NDArray[np.bool_]:
    return np.array([joint.prismatic for joint in robot.joints])


def _home(robot: RigidRobot, acceleration: Array) -> Array:
    """Return zero where ranges have it well inside, else their middle; bent if that is straight.

    Of a straight arm no joint shakes some directions.  The nearest of many poses is taken whose
    joints spread their torques over three directions about as well as any pose lets them.
    """
    home = []
    for joint in robot.joints:
        margin = NEAR_END * (joint.high - joint.low)
        inside = math.isinf(margin) or joint.low + margin <= 0.0 <= joint.high - margin
        home.append(0.0 if inside else 0.5 * (joint.low + joint.high))
    straight = np.array(home)
    poses = np.vstack([straight, _poses(robot)])
    poses = poses[np.argsort(np.linalg.norm(poses - straight, axis=1), kind='stable')]
    spans = np.array([_span(robot, pose, acceleration) for pose in poses])
    return np.asarray(np.round(poses[np.flatnonzero(spans >= SPAN * spans.max())[0]], 2))


def _span(robot: RigidRobot, pose: Array, acceleration: Array) -> float:
    """Return smallest over largest singular value of the torques, as a plan looks at them.

    Jiao et al. (2025), doi:10.1038/s41598-025-95339-6, Eqs. (17) to (20).
    """
    data = robot.model.createData()
    inertia = pin.crba(robot.model, data, pose)
    torque = np.sqrt((inertia**2) @ acceleration**2)
    axes = pin.computeJointJacobians(robot.model, data, pose)[3:]
    singular = np.linalg.svd(axes * torque, compute_uv=False)
    return float(singular[2] / singular[0]) if len(singular) > 2 else 0.0


def _poses(robot: RigidRobot) -> Array:
    """Return poses over all ranges, (POSES, n_joints)."""
    low = np.array([max(joint.low, -math.pi) for joint in robot.joints])
    high = np.array([min(joint.high, math.pi) for joint in robot.joints])
    return np.random.default_rng(SEED).uniform(low, high, (POSES, len(low)))


def _needed(robot: RigidRobot, acceleration: Array) -> Array:
    """Return twice the torque of weight and acceleration, the largest of many poses."""
    data = robot.model.createData()
    most = np.zeros(len(robot.joints))
    for pose in _poses(robot):
        weight = np.abs(pin.computeGeneralizedGravity(robot.model, data, pose))
        inertia = np.diag(pin.crba(robot.model, data, pose))
        most = np.maximum(most, weight + inertia * acceleration)
    return 2.0 * most


def _limits(robot: RigidRobot, speed: Array, effort: Array) -> dict[str, dict[str, float]]:
    return {
        joint.name: {
            'velocity_deg_s': _rounded(np.rad2deg(own)),
            'acceleration_deg_s2': _rounded(np.rad2deg(ACCELERATION_1_S * own)),
            'jerk_deg_s3': _rounded(np.rad2deg(JERK_1_S * ACCELERATION_1_S * own)),
            'effort_nm': _rounded(torque),
        }
        for joint, own, torque in zip(robot.joints, speed, effort, strict=True)
    }


def _joints(robot: RigidRobot, drive: Array, tilt: Array) -> dict[str, Any]:
    return {
        joint.name: {
            'drive': {'stiffness': _rounded(own)},
            'tilts': [{'stiffness': _rounded(across)} for _ in range(2)],
        }
        for joint, own, across in zip(robot.joints, drive, tilt, strict=True)
    }


def _lowest(model: FlexibleJointModel, home: Array) -> float:
    return float(model.modes(home).frequency_hz[0])


def _rayleigh(lowest_hz: float) -> dict[str, float]:
    """Return the two coefficients that damp two frequencies alike (alpha, beta of C = αM + βK)."""
    low = 2.0 * math.pi * lowest_hz
    return {
        'mass_proportional_1_s': _rounded(2.0 * DAMPING_RATIO * low * UP_TO / (1.0 + UP_TO)),
        'stiffness_proportional_s': _rounded(2.0 * DAMPING_RATIO / (low * (1.0 + UP_TO))),
    }


def _touching(model: FlexibleJointModel, home: Array) -> list[tuple[str, str]]:
    """Return pairs of bodies that are too near each other at home for any plan."""
    pairs: list[tuple[str, str]] = []
    while True:
        nearest = model.geometry.clearance(home)
        if nearest is None or nearest.distance_m >= TOUCHING_M:
            return pairs
        pairs.append((nearest.first, nearest.second))
        model = dataclasses.replace(model, collision_ignore=tuple(pairs))


def _rounded(value: float) -> float:
    return float(f'{value:.4g}')


def _text(mapping: Mapping[str, Any]) -> str:
    return yaml.safe_dump(dict(mapping), sort_keys=False, default_flow_style=None)
