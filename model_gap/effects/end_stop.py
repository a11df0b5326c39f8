"""A joint's twist runs into a stop."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel, JointForce
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from model_gap.laws import StopLaw


class EndStop(DetailedEffect):
    """A stiffness r·k beyond ±g about a middle, damped while it is pressed.

    The middle is where the arm hangs, and nothing is damped, until a fit is good.
    """

    type = 'end_stop'
    equation = "τ = r k sign(x - m) d max(1 + l d', 0), d = max(|x - m| - g, 0)"
    source = (
        'Shaw and Holmes (1983), doi:10.1016/0022-460X(83)90407-8; '
        'Hunt and Crossley (1975), doi:10.1115/1.3423596'
    )
    signature = 'as nominal below an amplitude, stiffer and with harmonics above it'
    says = '{place} runs into a stop {gap:.2g} rad from where it hangs'
    amplitude_dependent = True
    optional = ('loss',)  # models written before stops had one
    confused_with: ClassVar[Mapping[str, str]] = {
        'cubic_stiffness': 'a third, lower level: a spring still hardens, a stop is not reached',
        'backlash': 'a third, lower level: play is softest there, a stop is not reached',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per flexible joint."""
        return [cls(*place) for place in scene.joint_places]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return gap and stiffness, then where its middle is and how it is damped."""
        first = (
            EffectParameter('gap', 'rad', 1.5, 1e-6, 1e-2, neutral=1e-4, log=True),
            EffectParameter('stiffness_ratio', '1', 1.0, 0.02, 200.0, neutral=3.0, log=True),
        )
        if not self.details:
            return first
        return (
            *first,
            EffectParameter('middle', 'rad', 5e-5, -1e-3, 1e-3),
            # Half of the speed is lost where it is pressed at 0.75/l (restitution 1 - 2/3 l v).
            EffectParameter('loss', 's/rad', 20.0, 0.0, 1e3),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the torque."""
        force = JointForce(self.place, StopLaw, (*values, 0.0, 0.0)[:4])
        return dataclasses.replace(cell, forces=(*cell.forces, force))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return gaps over a decade."""
        return [(gap, 3.0) for gap in (1e-5, 4e-5, 1.5e-4)]

    def other_starts(self, values: tuple[float, ...]) -> Sequence[tuple[float, ...]]:
        """Return narrower and wider ones: a stop that is never reached leads nowhere."""
        return [(values[0] * factor, *values[1:]) for factor in (0.5, 2.0, 4.0)]
