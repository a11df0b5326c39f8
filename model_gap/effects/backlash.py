"""Play in one gear, preloaded by gravity."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel, JointForce
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.preloaded import law_values, PreloadedEffect
from model_gap.laws import BacklashLaw


class Backlash(PreloadedEffect):
    """τ = k·dz(e, b) about the twist under gravity; between the flanks the damper does not act."""

    type = 'backlash'
    equation = 'τ = k dz(e, b) + c ė on the flanks; dz(e, b) = sign(e) max(|e| - b, 0)'
    source = 'dead zone; Nordin and Gutman (2002), doi:10.1016/S0005-1098(02)00047-X'
    signature = 'frequency falls where the gravity load is small or the amplitude lifts the teeth'
    # Teeth rest on a flank under very little load.
    least_preload_rad = 1e-8
    most_share = 2.0
    says = '{place} has play: {half_gap:.2g} rad to either side'
    confused_with: ClassVar[Mapping[str, str]] = {
        'cubic_stiffness': 'a pose in which gravity loads the joint: preload closes the play',
        'joint_stiffness': 'a pose in which gravity loads the joint: preload closes the play',
        'coulomb_friction': 'a pose with gravity off the joint: play rattles, friction does not',
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return half the play, and how much of the computed gravity load is there."""
        return (
            EffectParameter('half_gap', 'rad', 1.5, 1e-7, 5e-3, neutral=3e-5, log=True),
            *self.preload(scene),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the play."""
        force = JointForce(self.place, BacklashLaw, law_values(values))
        return dataclasses.replace(cell, forces=(*cell.forces, force))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return plays over a decade and a half, fully and hardly preloaded."""
        gaps = (1.5e-5, 4e-5, 1e-4, 2.5e-4, 6e-4)
        return self.with_preload([(b, share) for b in gaps for share in (0.3, 1.0)], scene)

    def other_starts(self, values: tuple[float, ...]) -> Sequence[tuple[float, ...]]:
        """Return the same, less and more play, with all of gravity's load there.

        Play wider than the motion, its teeth never touching, promises much and leads nowhere.
        """
        whole = tuple(1.0 for _ in values[1:])
        return [(values[0] * factor, *whole) for factor in (1.0, 0.25, 0.0625, 4.0)]
