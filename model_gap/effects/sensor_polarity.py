"""One axis of a sensor, or all of them, reads with the wrong sign."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from model_gap.cell import gain_step, Setup
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.sensor_effect import AxisEffect


class SensorPolarity(AxisEffect):
    """y → -y."""

    type = 'sensor_polarity'
    equation = 'y -> -y'
    source = 'wiring or mounting upside down; Brandt (2011), Noise and Vibration Analysis, ch. 7'
    signature = 'one channel in antiphase with the model at every frequency and pose'
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_rotation': 'read static gravity in three poses'
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return none: a sign has no size."""
        return ()

    def apply(self, setup: Setup, values: Sequence[float], scene: Scene) -> Setup:
        """Turn the sign."""
        for axis, row in self.rows(setup).items():
            if self.variant in ('', axis):
                setup = setup.then_output(gain_step(row, -1.0))
        return setup

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return the only case."""
        return [()]
