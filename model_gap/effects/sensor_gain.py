"""One sensor, or one of its axes, has a wrong scale."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from model_gap.cell import CellModel, gain_step
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.sensor_effect import AxisEffect


class SensorGain(AxisEffect):
    """y_s → g·y_s."""

    type = 'sensor_gain'
    equation = 'y_s -> g y_s'
    source = 'calibration of accelerometers; ISO 16063-21'
    signature = 'one sensor larger or smaller by the same factor at all frequencies and poses'
    of_layout = True
    says = '{place} reads {gain:.3g} times what is there'
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_mount_resonance': 'a sharp tap: a resonance rises with frequency, a gain does not',
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the gain."""
        return (EffectParameter('gain', '1', 0.4, 0.02, 10.0, neutral=1.0, log=True),)

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Scale the channels."""
        for axis, row in self.rows(cell).items():
            if self.variant in ('', axis):
                cell = cell.then_output(gain_step(row, values[0]))
        return cell

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return a few factors; the fit is nearly linear."""
        return [(0.3,), (0.8,), (1.25,), (3.0,)]
