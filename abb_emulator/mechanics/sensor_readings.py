"""What ideal sensors on moving bodies read."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abb_emulator.mechanics.whole_arm import N_MOTION
from modal_core.channel import Channel
from modal_core.units import ANGULAR_VELOCITY
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class _Group:
    """The channels on one body."""

    columns: NDArray[np.intp]
    direction: Array
    position: Array
    moment: Array
    along: Array
    gyro: NDArray[np.bool_]


class SensorReadings:
    """Readings of channels, many instants at once.

    Parameters
    ----------
    model : FlexibleJointModel
        Knows which body of the expanded arm a sensor rides on.
    channels : sequence of Channel
        Columns.
    """

    def __init__(self, model: FlexibleJointModel, channels: Sequence[Channel]) -> None:
        members: dict[int, list[int]] = {}
        places, directions = [], []
        for number, channel in enumerate(channels):
            joint, placement = model.assembly.attach(
                channel.frame_id, np.array(channel.position_m)
            )
            members.setdefault(joint, []).append(number)
            places.append(placement.translation)
            directions.append(placement.rotation @ np.array(channel.direction))
        self.joints = tuple(members)
        self._n_channels = len(channels)
        self._groups = []
        for numbers in members.values():
            position = np.array([places[number] for number in numbers])
            direction = np.array([directions[number] for number in numbers])
            self._groups.append(
                _Group(
                    columns=np.array(numbers),
                    direction=direction,
                    position=position,
                    moment=np.cross(position, direction),
                    along=np.sum(position * direction, axis=1),
                    gyro=np.array([channels[n].unit == ANGULAR_VELOCITY for n in numbers]),
                )
            )

    def readings(self, motion: Array) -> Array:
        """Return d·(a - g) of accelerometers and d·ω of gyroscopes.

        Parameters
        ----------
        motion : (n_samples, 12 n_joints) array
            Of ``WholeArm.motion`` for ``joints``.

        Returns
        -------
        (n_samples, n_channels) array [m/s²] or [rad/s]
        """
        result = np.empty((len(motion), self._n_channels))
        for number, group in enumerate(self._groups):
            body = motion[:, number * N_MOTION : (number + 1) * N_MOTION]
            velocity, spin, force, spin_rate = (body[:, i : i + 3] for i in (0, 3, 6, 9))
            turn = spin @ group.direction.T
            part = (force + np.cross(spin, velocity)) @ group.direction.T
            part += spin_rate @ group.moment.T + turn * (spin @ group.position.T)
            part -= np.sum(spin * spin, axis=1)[:, None] * group.along
            result[:, group.columns] = np.where(group.gyro, turn, part)
        return result
