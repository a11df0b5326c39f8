"""What the sensors read on the mean, and what they should where the joints stood or moved."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from modal_core.channel import Channel
from model_gap.campaign import Campaign, standing, Travel, travel_of
from model_gap.cell import sag
from structural_model import FlexibleJointModel, ModelSpec
from structural_model.equations import rest_readings

Array = NDArray[np.float64]
G_M_S2 = 9.80665
# Of what should be read: a sensor that shows less everywhere takes its mean away (piezo, filter).
LEAST_SEEN = 0.03
# [rad] of a joint, for slopes.
STEP_RAD = 1e-4


@dataclass(frozen=True)
class AtRest:
    """Means of all channels in all records.

    Parameters
    ----------
    model : FlexibleJointModel
        The arm, as it hangs in its springs.
    channels : tuple of Channel
        Those that show gravity.
    left_out : tuple of str
        Sensors that do not.
    travels : tuple of Travel
        Where the joints stood in every record.
    measured : (n_records, n_channels) array [m/s²]
        Means.
    read : (n_records, n_channels) array of bool
        Which of them there are; zeros stand for the others.
    """

    model: FlexibleJointModel
    channels: tuple[Channel, ...]
    left_out: tuple[str, ...]
    travels: tuple[Travel, ...]
    measured: Array
    read: NDArray[np.bool_]

    @property
    def sensors(self) -> dict[str, list[int]]:
        """Columns of every sensor."""
        found: dict[str, list[int]] = {}
        for number, channel in enumerate(self.channels):
            found.setdefault(channel.sensor, []).append(number)
        return found

    def predicted(self, offset: Array) -> Array:
        """Return what should be read when the joints stand so far from what was recorded."""
        return np.array([self._mean(travel, offset) for travel in self.travels])

    def slopes(self, offset: Array) -> Array:
        """Return its derivative by every joint's offset, (n_joints, n_records, n_channels)."""
        base, found = self.predicted(offset), []
        for joint in range(len(offset)):
            moved = offset.copy()
            moved[joint] += STEP_RAD
            found.append((self.predicted(moved) - base) / STEP_RAD)
        return np.array(found)

    def tilts(self, offset: Array) -> Array:
        """Return its derivative by the robot's tilt about x and y, (2, n_records, n_channels)."""
        base, found = self.predicted(offset), []
        for turn in ((STEP_RAD, 0.0), (0.0, STEP_RAD)):
            model = replace(self.model, spec=tilted(self.model.spec, turn))
            found.append((replace(self, model=model).predicted(offset) - base) / STEP_RAD)
        return np.array(found)

    def in_poses(self, poses: Array) -> 'AtRest':
        """Return the same sensors in other poses, (n, n_joints), where nothing was read."""
        travels = tuple(map(standing, poses))
        shape = len(poses), len(self.channels)
        return replace(
            self, travels=travels, measured=np.zeros(shape), read=np.ones(shape, dtype=bool)
        )

    def _mean(self, travel: Travel, offset: Array) -> Array:
        """Return the mean on the way: a joint that moves turns gravity and carries sensors."""
        readings = [
            self._readings(position + offset, (velocity, acceleration))
            for position, velocity, acceleration in zip(
                travel.position, travel.velocity, travel.acceleration, strict=True
            )
        ]
        return np.asarray(travel.share @ np.array(readings))

    def _readings(self, pose: Array, motion: tuple[Array, Array]) -> Array:
        hanging = sag(self.model, pose, True)
        return rest_readings(self.model.dynamics, pose, self.channels, hanging, motion)


def tilted(spec: ModelSpec, turn: Sequence[float]) -> ModelSpec:
    """Return a spec of a robot that is tilted about its x and y [rad]."""
    level = Rotation.from_rotvec([turn[0], turn[1], 0.0]).inv().apply(spec.gravity_m_s2)
    x, y, z = level.tolist()
    return replace(spec, gravity_m_s2=(x, y, z))


def rest_of(model: FlexibleJointModel, campaign: Campaign) -> AtRest:
    """Return the means of a campaign, of the sensors that show gravity at all."""
    channels = campaign.layout.channels
    travels = tuple(travel_of(record) for record in campaign.records)
    measured = np.array([record.acceleration.mean(axis=0) for record in campaign.records])
    read = np.array([np.isin(np.arange(len(channels)), it.recorded) for it in campaign.records])
    whole = AtRest(model, channels, (), travels, measured, read)
    expected = read * whole.predicted(np.zeros(len(model.joint_names)))
    kept, left_out = [], []
    for name, columns in whole.sensors.items():
        size = np.linalg.norm(measured[:, columns])
        if size > LEAST_SEEN * np.linalg.norm(expected[:, columns]):
            kept += columns
        else:
            left_out.append(name)
    return replace(
        whole,
        channels=tuple(channels[column] for column in kept),
        left_out=tuple(left_out),
        measured=measured[:, kept],
        read=read[:, kept],
    )
