"""What the effects of one sensor share: where its channels are."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex
from model_gap.cell import CellModel, Filter
from model_gap.effects.effect import Effect, Scene


class SensorEffect(Effect):
    """An effect of one sensor: it cannot move poles."""

    moves_poles = False

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per sensor."""
        return [cls(f'sensor:{name}') for name in scene.sensors]

    @property
    def sensor(self) -> str:
        """Name of the sensor."""
        return str(self.location).removeprefix('sensor:')

    def rows(self, cell: CellModel) -> dict[str, int]:
        """Return the sensor's axes and their channel numbers."""
        return {
            channel.name.rsplit('.', 1)[-1]: number
            for number, channel in enumerate(cell.channels)
            if channel.name.rsplit('.', 1)[0] == self.sensor
        }


class AxisEffect(SensorEffect):
    """An effect of one sensor or of one of its axes, which is its variant."""

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per sensor and one per axis."""
        return [
            cls(f'sensor:{name}', axis)
            for name in scene.sensors
            for axis in ('', *axes_of(scene, name))
        ]


def axes_of(scene: Scene, sensor: str) -> list[str]:
    """Return the axes of a sensor that were recorded."""
    return [
        channel.name.rsplit('.', 1)[-1]
        for channel in scene.cell.channels
        if channel.name.rsplit('.', 1)[0] == sensor
    ]


def mixing_step(rows: Sequence[int], matrix: NDArray[np.float64]) -> Filter:
    """Return a step that mixes some channels by a matrix."""
    chosen = list(rows)

    def step(omega: NDArray[np.float64], spectra: Complex) -> Complex:
        mixed = spectra.copy()
        mixed[chosen] = matrix @ spectra[chosen]
        return mixed

    return step
