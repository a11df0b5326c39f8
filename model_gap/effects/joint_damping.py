"""The drive of one joint is more or less damped than the model says."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel, change_drive, Nuisance
from model_gap.effects.effect import Effect, EffectParameter, Scene
from structural_model.description import Spring


class JointDamping(Effect):
    """c_j → f·c_j, the material share included."""

    type = 'joint_damping'
    equation = 'c_j -> f c_j'
    source = 'viscous damper beside the drive spring; Spong (1987), doi:10.1115/1.3143860'
    signature = "damping of the joint's modes only; frequencies and amplitude dependence unchanged"
    says = '{place} is damped {factor:.3g} times as much as the model says'
    confused_with: ClassVar[Mapping[str, str]] = {
        'coulomb_friction': 'a second amplitude level: viscous damping keeps its ratio',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per flexible joint."""
        return [cls(joint) for joint in scene.flexible_joints]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the factor."""
        return (EffectParameter('factor', '1', 1.0, 0.02, 50.0, neutral=1.0, log=True),)

    def probe(self, cell: CellModel, scene: Scene) -> tuple[CellModel, str] | None:
        """Return the drive."""
        return cell, self.place

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Scale the drive's damping."""
        factor = values[0]

        def change(spring: Spring) -> Spring:
            return Spring(spring.stiffness, spring.damping * factor)

        return cell.with_spec(change_drive(cell.spec, str(self.location), change))

    def instead_of(
        self, tolerance: Nuisance, deviations: float, scene: Scene
    ) -> Sequence[Sequence[float]]:
        """Return the factor that the drive's tolerance has come to."""
        own = (tolerance.what, tolerance.joint) == ('damping', self.location)
        return [(float(np.exp(tolerance.sigma * deviations)),)] if own else ()

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return factors over two decades."""
        return [(float(f),) for f in np.exp(np.linspace(-1.6, 3.0, 8))]
