"""The gear of one joint turns unevenly."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel, Ripple
from model_gap.effects.effect import Effect, EffectParameter, Scene


class TransmissionError(Effect):
    """θ_e = a sin(N q) + b cos(N q) as motion of the motor side of the spring."""

    type = 'transmission_error'
    equation = 'θ_e = a sin(N q) + b cos(N q), a base motion of the drive spring'
    source = 'kinematic error of gears; Tuttle and Seering (1996), doi:10.1109/70.499818'
    signature = 'lines that move with the speed of one joint'
    says = 'The gear of {place} runs unevenly'
    moves_poles = False
    confused_with: ClassVar[Mapping[str, str]] = {
        'tonal_disturbance': 'change the joint speed by 20 %: the lines move in proportion',
    }

    def __init__(
        self, location: str | None = None, variant: str = '', seen: Ripple | None = None
    ) -> None:
        super().__init__(location, variant)
        self.seen = seen

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per order that was seen in a joint; once per turn of the motor elsewhere."""
        seen = [cls(item.joint, f'order {item.order_per_rad:.0f}', item) for item in scene.ripples]
        known = {effect.location for effect in seen}
        return [*seen, *(cls(joint) for joint in scene.flexible_joints if joint not in known)]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return amplitudes and order."""
        order = max(self.seen.order_per_rad if self.seen else self._ratio(scene), 1.0)
        return (
            EffectParameter('sine', 'rad', 1e-4, -3e-3, 3e-3),
            EffectParameter('cosine', 'rad', 1e-4, -3e-3, 3e-3),
            EffectParameter('order', '1/rad', 0.01, 0.3, 3000.0, neutral=order, log=True),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the error."""
        ripple = Ripple(str(self.location), values[2], values[0], values[1])
        return dataclasses.replace(cell, ripples=(*cell.ripples, ripple))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return what was seen, else once per turn of the motor at a few phases."""
        if self.seen is not None:
            return [(self.seen.sine_rad, self.seen.cosine_rad, self.seen.order_per_rad)]
        ratio = self._ratio(scene)
        size = 3e-5
        return [
            (size * float(np.cos(phase)), size * float(np.sin(phase)), ratio)
            for phase in (0.0, np.pi / 2, np.pi, -np.pi / 2)
            if ratio > 1.0
        ]

    def _ratio(self, scene: Scene) -> float:
        return next(j.drive.gear_ratio for j in scene.cell.spec.joints if j.name == self.location)
