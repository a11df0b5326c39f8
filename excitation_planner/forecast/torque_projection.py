"""Whether the plan pushes in every direction: the torque projection matrix D(τ), Eqs. (17)-(20).

Row j is the torque of joint j as a vector in the base frame: its axis, right-handed, times the
torque (rms) that it exerts on the structure, which is that of the links it turns without its own
rotor.  Rank 3 means the torques span space.  Jiao et al. (2025), doi:10.1038/s41598-025-95339-6.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# A direction with less than this part of the strongest one's torque (26 dB down) counts as not
# excited: what it excites drowns in what the others do at the same frequencies (assumed).
LEAST_RATIO = 0.05
# A joint adds the missing direction when its axis has at least this component along it.
HELPFUL_COMPONENT = 0.3
# Power of the norm that stands for the largest singular value.
SMOOTH = 8
# Poses looked at along a path.
N_POSES = 16


@dataclass(frozen=True, slots=True)
class TorqueProjection:
    """The torque projection matrix of one pose and what follows from it.

    Parameters
    ----------
    matrix : (n_joints, 3) array
        D(τ) in the base frame.
    singular_values : (3,) array
        Largest first.
    directions : (3, 3) array
        Rows: the directions in the base frame that belong to the singular values.
    rank : int
        Singular values of at least 5 % of the largest.
    missing : tuple of (3,) tuple
        Unit directions in the base frame that get no torque, or too little.
    helpful_joints : tuple of str
        Resting joints whose axis has a component along a missing direction; where there are none,
        those that move with too little torque.
    """

    matrix: Array
    singular_values: Array
    directions: Array
    rank: int
    missing: tuple[tuple[float, float, float], ...]
    helpful_joints: tuple[str, ...]

    @property
    def ratio(self) -> float:
        """Smallest over largest singular value."""
        largest = self.singular_values[0]
        return float(self.singular_values[-1] / largest) if largest > 0.0 else 0.0

    @property
    def _no_cure(self) -> str:
        few = len(self.matrix) < len(self.singular_values)
        return (
            'an arm of fewer than three joints has it in no pose: set require_full_rank false'
            if few
            else 'no joint adds it in this pose'
        )

    @property
    def reason(self) -> str:
        """Why the rank is below 3, in words; empty when it is 3."""
        if self.rank == 3:
            return ''
        directions = ' and '.join(_named(direction) for direction in self.missing)
        cure = ', '.join(self.helpful_joints)
        advice = f'joints that would add it: {cure}' if cure else self._no_cure
        return f'no torque about {directions}; {advice}'


@dataclass(frozen=True, slots=True)
class DirectionRatio:
    """How evenly torques spread over the directions.

    Parameters
    ----------
    smallest : float
        Smallest over largest singular value of D(τ).
    balance : float
        Its logarithm, but smooth where two directions are about as strong.
    needed : float
        What a plan needs of ``smallest``.
    """

    smallest: float
    balance: float
    needed: float = LEAST_RATIO


def direction_ratio(axes: Array, torque: Array) -> DirectionRatio:
    """Return how evenly torques about axes spread over the directions."""
    values = np.linalg.svd(axes * torque[:, None], compute_uv=False)
    smallest = values[2] if len(values) == 3 else 0.0
    largest = float(np.sum(values**SMOOTH) ** (1.0 / SMOOTH)) + 1e-300
    return DirectionRatio(
        smallest=float(smallest / max(values[0], 1e-300)),
        balance=float(np.log(smallest / largest + 1e-12)),
    )


def structure_torque(inertia: Array, acceleration_rms: Array) -> Array:
    """Return the torque (rms) of every axis on the structure; none of one that rests.

    Parameters
    ----------
    inertia : (n_joints, n_joints) array [kg m²]
        See ``FlexibleJointModel.link_inertia``.
    acceleration_rms : (n_joints,) array [rad/s²]
        Of the controller axes, which move independently.
    """
    torque = np.sqrt((inertia**2) @ acceleration_rms**2)
    return np.where(acceleration_rms > 0.0, torque, 0.0)


def projection_along(
    model: FlexibleJointModel, position: Array, acceleration_rms: Array
) -> TorqueProjection:
    """Return the projection where on a path its weakest direction is weakest.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    position : (n_samples, n_joints) array [rad]
        The path, serial joints.
    acceleration_rms : (n_joints,) array [rad/s²]
        Of the controller axes, in the band of interest.
    """
    rows = np.unique(np.linspace(0, len(position) - 1, N_POSES).astype(int))
    found = [
        torque_projection(
            joint_axes(model, q),
            structure_torque(model.link_inertia(q), acceleration_rms),
            model.axis_names,
        )
        for q in position[rows]
    ]
    return min(found, key=lambda projection: projection.ratio)


def joint_axes(model: FlexibleJointModel, q: Array) -> Array:
    """Return the joint axes in the base frame, (n_joints, 3); zero for a prismatic joint."""
    rotation = model.kinematics.motion(q).rotation[0, 1:]
    axes = np.array([joint.axis for joint in model.robot.joints])
    turns = np.array([not joint.prismatic for joint in model.robot.joints])
    return np.asarray(np.einsum('jab,jb->ja', rotation, axes) * turns[:, None])


def torque_projection(axes: Array, torque: Array, joint_names: Sequence[str]) -> TorqueProjection:
    """Project the joint torques on the base frame.

    Parameters
    ----------
    axes : (n_joints, 3) array
        Unit joint axes in the base frame at the pose.
    torque : (n_joints,) array [N m]
        Each joint's torque; 0 for a joint at rest.
    joint_names : sequence of str
        For the reason.
    """
    matrix = axes * torque[:, None]
    left_out = np.linalg.svd(matrix, full_matrices=True)
    values = np.zeros(3)
    values[: len(left_out.S)] = left_out.S
    directions = left_out.Vh
    rank = int(np.sum(values >= LEAST_RATIO * values[0])) if values[0] > 0.0 else 0
    lacking = directions[rank:]
    component = np.max(np.abs(axes @ lacking.T), axis=1) if len(lacking) else np.zeros(len(axes))
    order = [j for j in np.argsort(-component, kind='stable') if component[j] > HELPFUL_COMPONENT]
    resting = [joint for joint in order if torque[joint] == 0.0]
    return TorqueProjection(
        matrix=matrix,
        singular_values=values,
        directions=directions,
        rank=rank,
        missing=tuple(_unit(direction) for direction in lacking),
        helpful_joints=tuple(joint_names[joint] for joint in resting or order),
    )


def require_full_rank(projection: TorqueProjection) -> None:
    """Refuse a plan whose torques do not span space.

    Raises
    ------
    PlanError
        With the missing direction and the joints that would add it.
    """
    if projection.rank < 3:
        raise PlanError(
            'the torques on the structure do not span space',
            where='torque projection matrix',
            found=f'rank {projection.rank}, weakest direction {projection.ratio:.2g} of strongest',
            expected=f'rank 3, >= {LEAST_RATIO:g}',
            advice=projection.reason,
        )


def _unit(direction: Array) -> tuple[float, float, float]:
    """Turn a direction so that its largest component is positive."""
    sign = np.sign(direction[np.argmax(np.abs(direction))])
    x, y, z = (float(value) for value in np.round(sign * direction, 6) + 0.0)
    return x, y, z


def _named(direction: tuple[float, float, float]) -> str:
    for name, component in zip('xyz', direction, strict=True):
        if component > 0.999:
            return f'base {name}'
    return f'base direction ({direction[0]:.2f}, {direction[1]:.2f}, {direction[2]:.2f})'
