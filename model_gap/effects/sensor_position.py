"""A sensor sits elsewhere than the layout says."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel, Nuisance
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.sensor_effect import SensorEffect


class SensorPosition(SensorEffect):
    """p_s → p_s + d in the axes of its link."""

    type = 'sensor_position'
    equation = 'p_s -> p_s + d: y_s += (α × d) in the axes of the link'
    source = 'rigid-body acceleration; Ewins (2000), Modal Testing, sec. 3.6'
    signature = 'one sensor sees too much or too little of how its link turns; gravity is right'
    of_layout = True
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_gain': 'move one joint at a time: a gain is the same for every joint',
        'sensor_rotation': 'read static gravity in three poses: a place does not change it',
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the shift."""
        return tuple(EffectParameter(f'shift_{axis}', 'm', 0.1, -0.8, 0.8) for axis in 'xyz')

    @classmethod
    def in_words(cls, place: str, numbers: Mapping[str, float]) -> str:
        """Return how far and which way."""
        shift = [100.0 * numbers[f'shift_{axis}'] for axis in 'xyz']
        far = float(np.linalg.norm(shift))
        ways = ', '.join(f'{way:+.1f}' for way in shift)
        return f'{place} sits {far:.1f} cm elsewhere than its layout says ({ways} cm)'

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Move the channels."""
        rows, channels = set(self.rows(cell).values()), list(cell.channels)
        for row in rows:
            x, y, z = np.array(channels[row].position_m) + np.array(values)
            channels[row] = dataclasses.replace(channels[row], position_m=(x, y, z))
        return dataclasses.replace(cell, channels=tuple(channels))

    def instead_of(
        self, tolerance: Nuisance, deviations: float, scene: Scene
    ) -> Sequence[Sequence[float]]:
        """Return the shift that the tolerance of its place has come to."""
        if (tolerance.what, tolerance.sensor) != ('position', self.sensor):
            return ()
        return [tuple(tolerance.sigma * deviations * np.eye(3)['xyz'.index(tolerance.name[-2])])]

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return shifts to every side; what they do is proportional to them."""
        return [tuple(0.15 * sign * np.eye(3)[axis]) for axis in range(3) for sign in (1.0, -1.0)]
