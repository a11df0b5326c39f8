"""The motion happens later than the recorded motor side says."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel
from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.effects.sensor_delay import delay_step, delay_words


class CommandDelay(Effect):
    """u → u·e^{-iωτ}."""

    type = 'command_delay'
    equation = 'u -> u exp(-i ω τ)'
    source = 'shift theorem; feedback interfaces of robot controllers lag by a few samples'
    signature = 'the phase of every sensor falls alike, amplitudes and poles kept'
    moves_poles = False
    confused_with: ClassVar[Mapping[str, str]] = {'sensor_delay': 'a sensor of another recorder'}

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one."""
        return [cls(None)]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the delay."""
        return (EffectParameter('delay', 's', 0.008, -0.03, 0.06),)

    @classmethod
    def in_words(cls, place: str, numbers: Mapping[str, float]) -> str:
        """Return how late or early."""
        return f'All sensors show the recorded motion {delay_words(numbers["delay"])}'

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Delay the motor motion."""
        return cell.then_input(delay_step(values[0], None))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return delays a fraction of the shortest period apart."""
        return [(float(t),) for t in np.linspace(-0.02, 0.04, 31) if abs(t) > 1e-6]
