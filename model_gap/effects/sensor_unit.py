"""A sensor reads in g, and its recordings say m/s²."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from model_gap.cell import CellModel, gain_step
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.sensor_effect import SensorEffect

G_M_S2 = 9.80665


class SensorUnit(SensorEffect):
    """y_s → y_s / g."""

    type = 'sensor_unit'
    equation = 'y_s -> y_s / 9.80665 m/s²'
    source = 'standard acceleration of gravity; ISO 80000-3:2019, 3-11.2'
    signature = 'all axes of one sensor ten times too small, static gravity too'
    of_layout = True
    says = '{place} reads in g, not in m/s²'
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_gain': 'read static gravity: 1.00 upright is a unit',
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return none: a unit has no size."""
        return ()

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Scale the channels."""
        for row in self.rows(cell).values():
            cell = cell.then_output(gain_step(row, 1.0 / G_M_S2))
        return cell

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return the only case."""
        return [()]
