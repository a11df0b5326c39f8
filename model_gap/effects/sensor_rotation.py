"""A sensor is mounted askew."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np
import pinocchio as pin

from model_gap.cell import CellModel, Nuisance
from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.effects.sensor_effect import SensorEffect


class SensorRotation(SensorEffect):
    """y_s → R(r) y_s with a rotation vector r in the sensor's axes.

    The axes are turned, not the readings: gains are those of the turned axes.
    """

    type = 'sensor_rotation'
    equation = 'y_s -> R(r) y_s'
    source = 'rotation vector (Rodrigues); mounting error of tri-axial accelerometers'
    signature = "one sensor's axes mix, in every pose alike; static gravity is turned too"
    of_layout = True
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_axis_swap': 'read static gravity in three poses',
        'link_flexibility': 'a second sensor on the same link',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per tri-axial sensor."""
        names = [channel.name.rsplit('.', 1)[0] for channel in scene.cell.channels]
        return [cls(f'sensor:{name}') for name in scene.sensors if names.count(name) == 3]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the rotation vector."""
        return tuple(
            EffectParameter(f'rotation_{axis}', 'rad', 0.4, -np.pi, np.pi) for axis in 'xyz'
        )

    @classmethod
    def in_words(cls, place: str, numbers: Mapping[str, float]) -> str:
        """Return by how much."""
        angle = np.degrees(np.linalg.norm([numbers[f'rotation_{axis}'] for axis in 'xyz']))
        return f'{place} is mounted turned by {angle:.3g}°'

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Turn the three channels."""
        rows, channels = list(self.rows(cell).values()), list(cell.channels)
        directions = np.array([channels[row].direction for row in rows])
        turned = pin.exp3(np.array(values)) @ directions
        for row, (x, y, z) in zip(rows, turned.tolist(), strict=True):
            channels[row] = dataclasses.replace(channels[row], direction=(x, y, z))
        return dataclasses.replace(cell, channels=tuple(channels))

    def instead_of(
        self, tolerance: Nuisance, deviations: float, scene: Scene
    ) -> Sequence[Sequence[float]]:
        """Return the turn that the mount's tolerance has come to: readings turn the other way."""
        if (tolerance.what, tolerance.sensor) != ('rotation', self.sensor):
            return ()
        rows = list(self.rows(scene.cell).values())
        directions = np.array([scene.cell.channels[row].direction for row in rows])
        about = np.eye(3)['xyz'.index(tolerance.name[-2])]
        return [tuple((-tolerance.sigma * deviations * directions @ about).tolist())]

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return small and large turns about each axis."""
        return [
            tuple(angle if number == axis else 0.0 for number in range(3))
            for axis in range(3)
            for angle in (-2.2, -1.2, -0.4, 0.4, 1.2, 2.2)
        ]
