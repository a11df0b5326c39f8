"""What the effects of one sensor share: where its channels are."""

from collections.abc import Sequence
import dataclasses

import numpy as np
from numpy.typing import NDArray

from model_gap.effects.effect import Effect, Scene
from model_gap.setup import Filter, Setup
from model_gap.spectra import Complex


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

    def rows(self, setup: Setup) -> dict[str, int]:
        """Return the sensor's axes and their channel numbers."""
        return {
            channel.name.rsplit('.', 1)[-1]: number
            for number, channel in enumerate(setup.channels)
            if channel.name.rsplit('.', 1)[0] == self.sensor
        }


def mixing_step(rows: Sequence[int], matrix: NDArray[np.float64]) -> Filter:
    """Return a step that mixes some channels by a matrix."""
    chosen = list(rows)

    def step(omega: NDArray[np.float64], spectra: Complex) -> Complex:
        mixed = spectra.copy()
        mixed[chosen] = matrix @ spectra[chosen]
        return mixed

    return step


def directions(setup: Setup, rows: Sequence[int]) -> NDArray[np.float64]:
    """Return the sensitive directions as rows."""
    return np.array([setup.channels[row].direction for row in rows])


def turned(setup: Setup, rows: Sequence[int], rotation: NDArray[np.float64]) -> Setup:
    """Return a setup whose sensor is turned: its directions mix by the rotation's transpose."""
    channels = list(setup.channels)
    basis = directions(setup, rows)
    moved = rotation @ basis
    for row, direction in zip(rows, moved, strict=True):
        vector = (float(direction[0]), float(direction[1]), float(direction[2]))
        channels[row] = dataclasses.replace(channels[row], direction=vector)
    return dataclasses.replace(setup, channels=tuple(channels))
