"""The gear of one joint turns unevenly."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.setup import Ripple, Setup


class TransmissionError(Effect):
    """θ_e = a sin(N q) + b cos(N q) as motion of the motor side of the spring."""

    type = 'transmission_error'
    equation = 'θ_e = a sin(N q) + b cos(N q), a base motion of the drive spring'
    source = 'kinematic error of gears; Tuttle and Seering (1996), doi:10.1109/70.499818'
    signature = 'lines that move with the speed of one joint'
    moves_poles = False
    confused_with: ClassVar[Mapping[str, str]] = {
        'tonal_disturbance': 'change the joint speed by 20 %: the lines move in proportion',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per flexible joint."""
        return [cls(joint) for joint in scene.flexible_joints]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return amplitudes and order."""
        ratio = next(
            j.drive.gear_ratio for j in scene.setup.spec.joints if j.name == self.location
        )
        return (
            EffectParameter('sine', 'rad', 3e-5, -3e-3, 3e-3),
            EffectParameter('cosine', 'rad', 3e-5, -3e-3, 3e-3),
            EffectParameter(
                'order', '1/rad', 0.01, 0.3, 2000.0, neutral=max(ratio, 1.0), log=True
            ),
        )

    def apply(self, setup: Setup, values: Sequence[float], scene: Scene) -> Setup:
        """Add the error."""
        ripple = Ripple(str(self.location), values[2], values[0], values[1])
        return dataclasses.replace(setup, ripples=(*setup.ripples, ripple))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return the usual orders, once and twice per motor turn and per wave of the gear."""
        ratio = next(
            j.drive.gear_ratio for j in scene.setup.spec.joints if j.name == self.location
        )
        size = 3e-5
        return [
            (size * float(np.cos(phase)), size * float(np.sin(phase)), factor * ratio)
            for factor in (0.5, 1.0, 2.0)
            for phase in (0.0, np.pi / 2, np.pi, -np.pi / 2)
            if ratio > 1.0
        ]
