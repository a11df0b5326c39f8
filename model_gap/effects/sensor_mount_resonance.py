"""A sensor sits on a soft mount."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex
from model_gap.cell import CellModel, Filter
from model_gap.effects.effect import DetailedEffect, EffectParameter, Scene
from model_gap.effects.sensor_effect import AxisEffect


class SensorMountResonance(DetailedEffect, AxisEffect):
    """y → y·(1 + 2iδζr)/(1 - r² + 2iζr) with r = f/f_m: the base-excited mount, δ = 1.

    Damping that does not act between base and sensor, like that inside an accelerometer, is δ = 0:
    it is free once a fit is good.
    """

    type = 'sensor_mount_resonance'
    equation = 'y -> y (1 + 2iδζr)/(1 - r² + 2iζr), r = f/f_m'
    source = 'ISO 5348 (mechanical mounting of accelerometers)'
    signature = 'amplitude of one sensor rises with f², with a small lag'
    says = 'The mount of {place} is soft and resonates at {frequency:.3g} Hz'
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_gain': 'a tap: a gain is the same at all frequencies',
        'sensor_delay': 'a tap: a delay keeps the amplitude',
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return frequency and damping of the mount, and how much of it acts from the base."""
        first = (
            EffectParameter('frequency', 'Hz', 1.0, 20.0, 3000.0, neutral=150.0, log=True),
            EffectParameter('damping_ratio', '1', 1.0, 0.003, 0.7, neutral=0.05, log=True),
        )
        if not self.details:
            return first
        return (*first, EffectParameter('damping_from_base', '1', 1.0, -0.5, 1.5, neutral=1.0))

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Filter the channels."""
        rows = [row for axis, row in self.rows(cell).items() if self.variant in ('', axis)]
        return cell.then_output(_mount(2.0 * np.pi * values[0], rows, *values[1:]))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return frequencies from the band upwards."""
        return [(float(f), 0.05) for f in (25, 32, 40, 50, 65, 80, 110, 160, 250, 400)]


def _mount(resonance: float, rows: list[int], damping: float, from_base: float = 1.0) -> Filter:
    def step(omega: NDArray[np.float64], spectra: Complex) -> Complex:
        ratio = omega / resonance
        lag = 2j * damping * ratio
        found = spectra.copy()
        found[rows] = found[rows] * (1.0 + from_base * lag) / (1.0 - ratio**2 + lag)
        return found

    return step
