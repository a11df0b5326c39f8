"""The drive's stiffness depends on how fast the joint turns."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel, JointForce
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.preloaded import law_values, PreloadedEffect
from model_gap.laws import SpeedStiffnessLaw


class SpeedDependentStiffness(PreloadedEffect):
    """k_j(q') = k_j (1 + β|q'|), gravity's twist included."""

    type = 'speed_dependent_stiffness'
    equation = "τ = k (1 + β |q'|) (r + e), r the twist at rest"
    source = 'Tunc and Gonul (2021), doi:10.1016/j.cirp.2021.04.006'
    signature = 'frequency differs between standstill and motion of one joint'
    says = 'The stiffness of {place} changes with its speed'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'the same pose at standstill and while the joint turns steadily',
        'cubic_stiffness': 'the same pose at standstill and while the joint turns steadily',
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return β, and how much of the computed gravity load is there."""
        return (
            EffectParameter('beta', 's/rad', 2.0, -30.0, 100.0),
            *self.preload(scene),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the change of stiffness."""
        force = JointForce(self.place, SpeedStiffnessLaw, law_values(values))
        return dataclasses.replace(cell, forces=(*cell.forces, force))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return softer and stiffer springs, with and without preload."""
        betas = (-4.0, -1.0, 1.0, 4.0)
        return self.with_preload([(beta, share) for beta in betas for share in (0.0, 1.0)], scene)
