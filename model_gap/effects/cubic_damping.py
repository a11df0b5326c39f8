"""A joint is damped the more the faster it twists."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel, JointForce
from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.laws import CubicDampingLaw


class CubicDamping(Effect):
    """τ = c v³, v the twist's rate."""

    type = 'cubic_damping'
    equation = "τ = c x'³"
    source = 'Elliott, Tehrani and Langley (2015), doi:10.1098/rsta.2014.0402'
    signature = 'damping rises as amplitude rises, frequency stays'
    says = '{place} is damped by the cube of its speed'
    amplitude_dependent = True
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_damping': 'a third, lower amplitude level: viscous damping keeps its ratio',
        'coulomb_friction': 'a third level: friction damps less where motion is larger',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per flexible joint."""
        return [cls(*place) for place in scene.joint_places]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the coefficient."""
        return (EffectParameter('coefficient', 'N m s³/rad³', 1e7, 0.0, 1e12),)

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the torque."""
        force = JointForce(self.place, CubicDampingLaw, (values[0],))
        return dataclasses.replace(cell, forces=(*cell.forces, force))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return coefficients over four decades."""
        return [(size,) for size in (1e5, 1e7, 1e9)]
