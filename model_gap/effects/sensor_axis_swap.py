"""Two axes of a sensor are exchanged."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel
from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.effects.sensor_effect import axes_of, mixing_step, SensorEffect


class SensorAxisSwap(SensorEffect):
    """(y_a, y_b) → (y_b, y_a)."""

    type = 'sensor_axis_swap'
    equation = '(y_a, y_b) -> (y_b, y_a)'
    source = 'exchanged cables; Brandt (2011), Noise and Vibration Analysis, ch. 7'
    signature = "two channels of one sensor carry each other's signal"
    of_layout = True
    says = 'Two axes of {place} are exchanged'
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_rotation': 'read static gravity in three poses'
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per pair of axes."""
        return [
            cls(f'sensor:{name}', first + second)
            for name in scene.sensors
            for first, second in combinations(axes_of(scene, name), 2)
        ]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return none."""
        return ()

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Exchange the two channels."""
        rows = self.rows(cell)
        pair = [rows[self.variant[0]], rows[self.variant[1]]]
        return cell.then_output(mixing_step(pair, np.array([[0.0, 1.0], [1.0, 0.0]])))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return the only case."""
        return [()]
