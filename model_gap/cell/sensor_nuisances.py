"""Tolerances of the sensors: where they are, how they are turned, what they read."""

from collections.abc import Callable, Sequence
import dataclasses
import math

import numpy as np
import pinocchio as pin

from modal_core.channel import AXES, Channel
from model_gap.cell.cell_model import CellModel
from model_gap.cell.changes import gain_step
from model_gap.cell.nuisance import Nuisance

# Turning a sensor about the one axis it reads shows nothing.
LEAST_TURNED = 0.1


def sensor_nuisances(
    channels: Sequence[Channel], position_m: float, rotation_deg: float, gain: float
) -> list[Nuisance]:
    """Return tolerances of every sensor's place and mount, and of every channel's gain."""
    found = []
    sensors: dict[str, list[Channel]] = {}
    for channel in channels:
        sensors.setdefault(sensor_of(channel), []).append(channel)
    for sensor in sensors:
        found += [_position(sensor, axis, position_m) for axis in range(3)]
    for sensor, own in sensors.items():
        found += [
            _rotation(sensor, axis, rotation_deg)
            for axis in AXES
            if any(_turned(channel, axis) for channel in own)
        ]
    found += [_gain(channel.name, gain) for channel in channels]
    return found


def sensor_of(channel: Channel) -> str:
    """Return the name of a channel's sensor."""
    return channel.name.rsplit('.', 1)[0]


def _turned(channel: Channel, axis: str) -> bool:
    across = np.cross(AXES[axis], channel.direction)
    return bool(np.linalg.norm(across) > LEAST_TURNED * np.linalg.norm(channel.direction))


def _of_sensor(
    sensor: str, change_by: Callable[[float], Callable[[Channel], Channel]]
) -> Callable[[CellModel, float], CellModel]:
    def apply(cell: CellModel, amount: float) -> CellModel:
        change = change_by(amount)
        channels = tuple(
            change(channel) if sensor_of(channel) == sensor else channel
            for channel in cell.channels
        )
        return dataclasses.replace(cell, channels=channels)

    return apply


def _position(sensor: str, axis: int, sigma_m: float) -> Nuisance:
    def change_by(amount: float) -> Callable[[Channel], Channel]:
        def change(channel: Channel) -> Channel:
            place = list(channel.position_m)
            place[axis] += amount
            return dataclasses.replace(channel, position_m=(place[0], place[1], place[2]))

        return change

    name = f'position of {sensor} ({"xyz"[axis]})'
    moved = _of_sensor(sensor, change_by)
    return Nuisance(name, 'sensor', moved, sigma_m, 'm', 'position', sensor=sensor)


def _rotation(sensor: str, axis: str, sigma_deg: float) -> Nuisance:
    about = np.array(AXES[axis])

    def change_by(amount: float) -> Callable[[Channel], Channel]:
        turn = pin.exp3(amount * about)

        def change(channel: Channel) -> Channel:
            x, y, z = (turn @ channel.direction).tolist()
            return dataclasses.replace(channel, direction=(x, y, z))

        return change

    return Nuisance(
        f'rotation of {sensor} ({axis})',
        'sensor',
        _of_sensor(sensor, change_by),
        float(np.deg2rad(sigma_deg)),
        'rad',
        'rotation',
        sensor=sensor,
    )


def _gain(name: str, sigma: float) -> Nuisance:
    def apply(cell: CellModel, amount: float) -> CellModel:
        number = [channel.name for channel in cell.channels].index(name)
        return cell.then_output(gain_step(number, math.exp(amount)))

    return Nuisance(f'gain of {name}', 'gain', apply, sigma)
