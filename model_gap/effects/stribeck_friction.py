"""Dry friction that is larger before it slides fast."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from model_gap.cell import CellModel
from model_gap.effects.coulomb_friction import CoulombFriction, Laws
from model_gap.effects.effect import EffectParameter, Scene
from model_gap.laws import FrictionCurveLaw, WholeFrictionCurveLaw


class StribeckFriction(CoulombFriction):
    """τ_c·(1 + s·exp(-(w/v_s)²))·tanh(w/v₀), as Coulomb's in the gear or on the whole joint."""

    type = 'stribeck_friction'
    equation = "τ_f = τ_c (1 + s exp(-(w/v_s)²)) tanh(w/v_0), w = v - p τ_f'/k"
    source = 'Armstrong-Hélouvry et al. (1994), doi:10.1016/0005-1098(94)90209-7'
    signature = 'as dry friction, but at low amplitude damping falls faster than 1/amplitude'
    says = '{place} has dry friction of {torque:.3g} N m, and {rise:.2g} times more as it starts'
    special_case = 'coulomb_friction'
    confused_with: ClassVar[Mapping[str, str]] = {
        'coulomb_friction': 'a third, lower amplitude level: at low speed Stribeck friction holds '
        'more',
        'load_friction': 'a pose that loads the joint otherwise: Stribeck friction stays',
    }
    laws: ClassVar[Laws] = (FrictionCurveLaw, WholeFrictionCurveLaw)

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return level and transition speed, how much more there is, and up to which speed."""
        return (
            *CoulombFriction(self.location, self.variant).parameters(scene),
            EffectParameter('rise', '1', 1.0, 0.0, 10.0),
            EffectParameter('stribeck_speed', 'rad/s', 1.0, 1e-4, 1.0, neutral=5e-3, log=True),
            *self.presliding,
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the torque."""
        return self.with_torque(cell, (*values[:4], 0.0), values[4:])

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return levels over two decades."""
        return [(*start, 1.0, 5e-3) for start in super().starts(scene)]

    def generalise(self, values: tuple[float, ...]) -> Sequence[tuple[float, ...]]:
        """Return knees to either side of the speeds that an arm is shaken at."""
        torque, width, *presliding = values
        return [(0.7 * torque, width, 1.0, speed, *presliding) for speed in (2e-3, 1e-2)]
