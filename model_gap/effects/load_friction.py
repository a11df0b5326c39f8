"""Dry friction that grows with the load of the gear."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from model_gap.cell import CellModel
from model_gap.effects.coulomb_friction import CoulombFriction, Laws
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.laws import FrictionCurveLaw, WholeFrictionCurveLaw


class LoadFriction(CoulombFriction):
    """(τ_c + μ|k (r + e)|)·tanh(w/v₀), r the twist under gravity: the gear's whole torque."""

    type = 'load_friction'
    equation = "τ_f = (τ_c + μ |k (r + e)|) tanh(w/v_0), w = v - p τ_f'/k, r the twist at rest"
    source = 'Hamon, Gautier and Garrec (2010), doi:10.1109/IROS.2010.5649189'
    signature = 'as dry friction, but more of it in poses in which gravity loads the joint'
    says = '{place} has dry friction of {torque:.3g} N m, and of {share:.2g} of its load'
    special_case = 'coulomb_friction'
    confused_with: ClassVar[Mapping[str, str]] = {
        'coulomb_friction': 'poses with gravity on and off the joint: load makes friction',
        'stribeck_friction': 'a third amplitude level: load friction does not ask for speed',
    }
    laws: ClassVar[Laws] = (FrictionCurveLaw, WholeFrictionCurveLaw)

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return level and transition speed, and the share of the load."""
        return (
            *CoulombFriction(self.location, self.variant).parameters(scene),
            EffectParameter('share', '1', 0.1, 0.0, 1.0),
            *self.presliding,
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the torque."""
        torque, width, share, *presliding = values
        return self.with_torque(cell, (torque, width, 0.0, 1.0, share), presliding)

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return levels over two decades."""
        return [(*start, 0.05) for start in super().starts(scene)]

    def generalise(self, values: tuple[float, ...]) -> Sequence[tuple[float, ...]]:
        """Return much and little of it made by load."""
        torque, width, *presliding = values
        return [
            (0.7 * torque, width, 0.01, *presliding),
            (0.3 * torque, width, 0.05, *presliding),
        ]
