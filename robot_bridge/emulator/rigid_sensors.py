"""What sensors read when the arm moves as a rigid one, for many instants at once.

The outward recursion of Luh, Walker and Paul in link frames, all instants vectorised.  Gravity
comes in as an upward acceleration of the base.

References
----------
Luh, Walker and Paul (1980), doi:10.1115/1.3149599.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import ANGULAR_VELOCITY, Channel
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Group:
    """The channels on one moving body: rows to weigh its motion with."""

    joint: int
    columns: NDArray[np.intp]
    direction: Array
    position: Array
    moment: Array
    along: Array
    gyro: NDArray[np.bool_]


class RigidSensors:
    """Readings of sensors on a rigid arm.

    Parameters
    ----------
    model : FlexibleJointModel
        Joint tree of revolute joints and places of the links.
    channels : sequence of Channel
        Sensor axes.
    """

    def __init__(self, model: FlexibleJointModel, channels: Sequence[Channel]) -> None:
        tree = model.robot.model
        self._parents = [int(parent) for parent in tree.parents]
        self._turns = [np.array(item.rotation) for item in tree.jointPlacements]
        self._arms = [np.array(item.translation) for item in tree.jointPlacements]
        self._axes = [np.zeros(3), *(np.array(joint.axis) for joint in model.robot.joints)]
        self._up = -np.array(model.spec.gravity_m_s2)
        self._n_channels = len(channels)
        self._groups = _groups(model, channels)

    def readings(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return d·(a - g) of accelerometers and d·ω of gyroscopes.

        Parameters
        ----------
        q, qd, qdd : (n_samples, n_joints) array [rad], [rad/s], [rad/s²]
            Serial joint motion.

        Returns
        -------
        (n_samples, n_channels) array [m/s²] or [rad/s]
        """
        motions = self._outward(q, qd, qdd)
        result = np.empty((len(q), self._n_channels))
        for group in self._groups:
            spin, spin_rate, force = motions[group.joint]
            part = force @ group.direction.T + spin_rate @ group.moment.T
            turn = spin @ group.direction.T
            part += turn * (spin @ group.position.T)
            part -= np.sum(spin * spin, axis=1)[:, None] * group.along
            result[:, group.columns] = np.where(group.gyro, turn, part)
        return result

    def _outward(self, q: Array, qd: Array, qdd: Array) -> list[tuple[Array, Array, Array]]:
        """Return ω, ω' and specific force of every body's origin, in its own axes."""
        still = np.zeros((len(q), 3))
        motions = [(still, still, np.tile(self._up, (len(q), 1)))]
        for joint in range(1, len(self._parents)):
            spin, spin_rate, force = motions[self._parents[joint]]
            arm, axis = self._arms[joint], self._axes[joint]
            force = force + _cross(spin_rate, arm) + _cross(spin, _cross(spin, arm))
            turn = self._turns[joint]
            angle, rate, rise = (part[:, joint - 1, None] for part in (q, qd, qdd))
            spin, spin_rate, force = (
                _turn_back(part @ turn, axis, angle) for part in (spin, spin_rate, force)
            )
            spin_rate = spin_rate + axis * rise + _cross(spin, axis) * rate
            motions.append((spin + axis * rate, spin_rate, force))
        return motions


def _cross(first: Array, second: Array) -> Array:
    a, b = first.T, second.T
    result = np.empty_like(first)
    result[:, 0] = a[1] * b[2] - a[2] * b[1]
    result[:, 1] = a[2] * b[0] - a[0] * b[2]
    result[:, 2] = a[0] * b[1] - a[1] * b[0]
    return result


def _turn_back(vector: Array, axis: Array, angle: Array) -> Array:
    """Rotate vectors by -angle about a unit axis (Rodrigues)."""
    sine, cosine = np.sin(angle), np.cos(angle)
    along = (vector @ axis)[:, None] * axis
    return np.asarray(along + cosine * (vector - along) + sine * _cross(vector, axis))


def _groups(model: FlexibleJointModel, channels: Sequence[Channel]) -> list[_Group]:
    members: dict[int, list[int]] = {}
    places, directions = [], []
    for number, channel in enumerate(channels):
        joint, placement = model.assembly.link(channel.frame_id)
        members.setdefault(joint, []).append(number)
        places.append(placement.act(np.array(channel.position_m)))
        directions.append(placement.rotation @ np.array(channel.direction))
    groups = []
    for joint, numbers in members.items():
        position = np.array([places[number] for number in numbers])
        direction = np.array([directions[number] for number in numbers])
        groups.append(
            _Group(
                joint=joint,
                columns=np.array(numbers),
                direction=direction,
                position=position,
                moment=np.cross(position, direction),
                along=np.sum(position * direction, axis=1),
                gyro=np.array([channels[n].unit == ANGULAR_VELOCITY for n in numbers]),
            )
        )
    return groups
