"""Whether the plan pushes in every direction: the torque projection matrix D(τ), Eqs. (12)-(20).

Row j is the torque of joint j as a vector in the base frame: its axis, right-handed, times the
share the plan uses of it.  Rank 3 means the torques span space.  Jiao et al. (2025),
doi:10.1038/s41598-025-95339-6.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import PlanError

Array = NDArray[np.float64]
# A direction with less than this part of the strongest one's torque counts as not excited:
# 40 dB down it drowns in sensor noise.
RANK_TOLERANCE = 0.01
# A joint adds the missing direction when its axis has at least this component along it.
HELPFUL_COMPONENT = 0.3


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
        Singular values above 1 % of the largest.
    missing : tuple of (3,) tuple
        Unit directions in the base frame that get no torque.
    helpful_joints : tuple of str
        Resting joints whose axis has a component along a missing direction.
    """

    matrix: Array
    singular_values: Array
    directions: Array
    rank: int
    missing: tuple[tuple[float, float, float], ...]
    helpful_joints: tuple[str, ...]

    @property
    def condition_number(self) -> float:
        """Largest over smallest singular value; infinite when a direction is missing."""
        smallest = self.singular_values[-1]
        return float(self.singular_values[0] / smallest) if smallest > 0.0 else float('inf')

    @property
    def reason(self) -> str:
        """Why the rank is below 3, in words; empty when it is 3."""
        if self.rank == 3:
            return ''
        directions = ' and '.join(_named(direction) for direction in self.missing)
        cure = ', '.join(self.helpful_joints)
        advice = f'joints that would add it: {cure}' if cure else 'no joint adds it in this pose'
        return f'no torque about {directions}; {advice}'


def torque_projection(axes: Array, torque: Array, joint_names: Sequence[str]) -> TorqueProjection:
    """Project the joint torques on the base frame.

    Parameters
    ----------
    axes : (n_joints, 3) array
        Unit joint axes in the base frame at the pose.
    torque : (n_joints,) array
        Share or amplitude of each joint's torque; 0 for a joint at rest.
    joint_names : sequence of str
        For the reason.
    """
    matrix = axes * torque[:, None]
    left_out = np.linalg.svd(matrix, full_matrices=True)
    values = np.zeros(3)
    values[: len(left_out.S)] = left_out.S
    directions = left_out.Vh
    rank = int(np.sum(values > RANK_TOLERANCE * values[0])) if values[0] > 0.0 else 0
    lacking = directions[rank:]
    component = np.max(np.abs(axes @ lacking.T), axis=1) if len(lacking) else np.zeros(len(axes))
    order = np.argsort(-component, kind='stable')
    helpful = [
        joint_names[joint]
        for joint in order
        if torque[joint] == 0.0 and component[joint] > HELPFUL_COMPONENT
    ]
    return TorqueProjection(
        matrix=matrix,
        singular_values=values,
        directions=directions,
        rank=rank,
        missing=tuple(_unit(direction) for direction in lacking),
        helpful_joints=tuple(helpful),
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
            'the torques do not span space',
            where='torque projection matrix',
            found=f'rank {projection.rank}',
            expected='rank 3',
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
