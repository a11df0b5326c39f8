"""The drive hardens or softens with its twist, that under gravity included."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel, JointForce
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.effects.preloaded import law_values, PreloadedEffect
from model_gap.laws import CubicLaw


class CubicStiffness(PreloadedEffect):
    """τ = k y (1 + α y²) of the twist y."""

    type = 'cubic_stiffness'
    equation = 'τ = k y (1 + α y²), y = r + e: at rest and beyond; k_eq = k (1 + 3 α (r² + σ_e²))'
    source = 'Mohammadi; Kerschen et al. (2006), doi:10.1016/j.ymssp.2005.04.008'
    signature = 'frequency moves with amplitude and gravity load, damping does not; harmonics'
    says = 'The stiffness of {place} changes with its twist'
    confused_with: ClassVar[Mapping[str, str]] = {
        'backlash': 'a third, larger level: play fades, a cubic spring grows',
        'coulomb_friction': 'a third, lower level: friction then damps more',
        'joint_stiffness': 'a second amplitude level: a linear spring keeps its frequency',
    }

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return α, and how much of the computed gravity load is there."""
        return (
            EffectParameter('alpha', '1/rad²', 3e6, -1e7, 1e9),
            *self.preload(scene),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the cubic part."""
        force = JointForce(self.place, CubicLaw, law_values(values))
        return dataclasses.replace(cell, forces=(*cell.forces, force))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return softening and hardening, with and without preload.

        Without, the torque is proportional to α on a measured twist: one value stands for many.
        """
        loaded = [(alpha, 1.0) for alpha in (-2e5, 2e5, 1e6, 5e6)]
        return self.with_preload([*loaded, (-5e5, 0.0), (1e6, 0.0), (2e7, 0.0)], scene)

    def other_starts(self, values: tuple[float, ...]) -> Sequence[tuple[float, ...]]:
        """Return the same, less and more, with all of gravity's load there."""
        whole = tuple(1.0 for _ in values[1:])
        return [(values[0] * factor, *whole) for factor in (1.0, 0.25, 4.0)]
