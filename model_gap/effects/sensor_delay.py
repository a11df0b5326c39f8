"""One sensor's clock is late or early."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex
from model_gap.cell import CellModel, Filter
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.sensor_effect import SensorEffect


class SensorDelay(SensorEffect):
    """y_s → y_s·e^{-iωτ}."""

    type = 'sensor_delay'
    equation = 'y_s -> y_s exp(-i ω τ)'
    source = 'shift theorem; skew between recorders'
    signature = 'phase of one sensor falls in proportion to frequency, amplitude kept'
    confused_with: ClassVar[Mapping[str, str]] = {
        'sensor_mount_resonance': 'a tap near all sensors: a delay keeps the amplitude',
        'command_delay': 'sensors of another recorder',
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the delay."""
        return (EffectParameter('delay', 's', 0.005, -0.03, 0.03),)

    @classmethod
    def in_words(cls, place: str, numbers: Mapping[str, float]) -> str:
        """Return how late or early."""
        return f'{place} is {delay_words(numbers["delay"])}'

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Delay the sensor's channels."""
        return cell.then_output(delay_step(values[0], list(self.rows(cell).values())))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return delays a fraction of the shortest period apart."""
        return [(float(t),) for t in np.linspace(-0.02, 0.02, 21) if t]


def delay_words(delay_s: float) -> str:
    """Return a delay as people say it."""
    return f'{1e3 * abs(delay_s):.3g} ms {"early" if delay_s < 0.0 else "late"}'


def delay_step(delay_s: float, rows: list[int] | None) -> Filter:
    """Return a step that delays some rows, or all."""

    def step(omega: NDArray[np.float64], spectra: Complex) -> Complex:
        late = spectra.copy()
        chosen = slice(None) if rows is None else rows
        late[chosen] = late[chosen] * np.exp(-1j * omega * delay_s)
        return late

    return step
