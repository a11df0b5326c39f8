"""The coupling rod of a parallelogram is elastic, or its spring is missing in the model."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel
from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.effects.places import stiffest, unused_name
from structural_model.description import RodSpec, Spring


class RodSpring(Effect):
    """K += k wwᵀ with w = e₂ ± e₃ (two neighbouring joints)."""

    type = 'rod_spring'
    equation = 'K += k w wᵀ, w = e_2 ± e_3'
    source = 'parallelogram arms; Klimchik et al. (2017), doi:10.1016/j.mechmachtheory.2016.12.002'
    signature = 'couples joints 2 and 3: motion of one moves the other'
    says = 'A rod couples joints 2 and 3 that the model does not have'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'excite joint 3 alone and watch joint 2'
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return both signs over joints 2 and 3, where both are flexible.

        Not the one that a drive acts along through its own rod: that is a stiffer drive.
        """
        names = scene.model.joint_names
        if len(names) < 3 or not {names[1], names[2]} <= set(scene.flexible_joints):
            return []
        drives = scene.model.axes.matrix
        signs = {'+': 1.0, '-': -1.0}
        weights = {
            sign: np.eye(len(names))[1] + s * np.eye(len(names))[2] for sign, s in signs.items()
        }
        return [
            cls(f'{names[1]}+{names[2]}', sign)
            for sign, weight in weights.items()
            if not any(np.array_equal(row, weight) for row in drives)
        ]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the stiffness and how lossy it is."""
        unit = 0.5 * stiffest(scene)
        return (
            EffectParameter('stiffness', 'N m/rad', unit, 0.0, 50.0 * unit),
            EffectParameter('loss_time', 's', 0.7, 1e-5, 1e-2, neutral=3e-4, log=True),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the spring."""
        names = scene.model.joint_names
        sign = 1.0 if self.variant == '+' else -1.0
        rod = RodSpec(
            name=unused_name(f'gap_rod_{"sum" if sign > 0 else "difference"}', cell.spec.rods),
            weights=((names[1], 1.0), (names[2], sign)),
            spring=Spring(max(values[0], 1e-3), values[1] * max(values[0], 1e-3)),
        )
        return cell.with_spec(dataclasses.replace(cell.spec, rods=(*cell.spec.rods, rod)))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return stiffnesses over two decades."""
        return [(float(0.5 * stiffest(scene) * f), 3e-4) for f in np.geomspace(0.03, 10.0, 16)]
