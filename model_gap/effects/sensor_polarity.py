"""One axis of a sensor, or all of them, reads with the wrong sign."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from model_gap.cell import CellModel, gain_step
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.sensor_effect import AxisEffect


class SensorPolarity(AxisEffect):
    """y → -y."""

    type = 'sensor_polarity'
    equation = 'y -> -y'
    source = 'wiring or mounting upside down; Brandt (2011), Noise and Vibration Analysis, ch. 7'
    signature = 'one channel in antiphase with the model at every frequency and pose'
    of_layout = True
    says = '{place} is connected the wrong way round'
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_rotation': 'read static gravity in three poses'
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return none: a sign has no size."""
        return ()

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Turn the sign."""
        for axis, row in self.rows(cell).items():
            if self.variant in ('', axis):
                cell = cell.then_output(gain_step(row, -1.0))
        return cell

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return the only case."""
        return [()]
