"""A joint is damped the more the faster it twists."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel, joint_spring, JointForce
from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.laws import CubicDampingLaw

USUAL_S3 = 30.0
"""Coefficient over stiffness of 3 % at 10 Hz and 0.1 mrad: 3/4 c (ω x)² = 2 ζ k/ω, rounded.

It centres a wide prior alone: known to 1.5 %, eight times as much is pulled by 0.005 σ.
"""


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
        usual = self._usual(scene)
        low, high = 1e-6 * usual, 1e6 * usual
        # One standard deviation: from a twelfth to twelve times as much.
        return (EffectParameter('coefficient', 'N m s³/rad³', 2.5, low, high, usual, log=True),)

    def _usual(self, scene: Scene) -> float:
        """Return what damps a joint that swings by 0.1 mrad at 10 Hz by 3 % of critical."""
        return USUAL_S3 * joint_spring(scene.cell.spec, self.place).stiffness

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the torque."""
        force = JointForce(self.place, CubicDampingLaw, (values[0],))
        return dataclasses.replace(cell, forces=(*cell.forces, force))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return coefficients over four decades."""
        return [(size * self._usual(scene),) for size in (0.01, 1.0, 100.0)]
