"""Part of a joint's stiffness slips: bolts, fits, a gear's hysteresis."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel, JointForce
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from model_gap.laws import HysteresisLaw

KNEE = 4.0
"""Until it is free, between what arms may have: χ of a sharp one (seed 707003, small campaign) is
1.0, 1.3, 2.0 with n = 40, 4, 2; of one with n = 2 (707003) it is 1.18, 1.11, 1.07.  Four others
with n = 2, on which it was not chosen, were named from it (seeds 777000 to 777002).
"""


class Hysteresis(DetailedEffect):
    """A spring s·k beside the joint's own that slips at the twist x_y.

    How sharp its knee is (n; Bouc and Wen's is often 1 to 2, Jenkin's is sharp) is free once a fit
    is good.
    """

    type = 'hysteresis'
    equation = "τ = s k z, z' = x' (1 - |z/x_y|ⁿ) outwards, x' inwards"
    source = 'Wen (1976), doi:10.1061/JMCEA3.0002106; Iwan (1966), doi:10.1115/1.3625199'
    signature = 'frequency falls as amplitude rises; damping is largest between, small beyond'
    says = 'A part of {place}, {share:.2g} times its stiffness, slips at {limit:.2g} rad'
    amplitude_dependent = True
    confused_with: ClassVar[Mapping[str, str]] = {
        'coulomb_friction': 'four levels: hysteresis is stiffer at the lowest, friction sticks',
        'cubic_stiffness': 'four levels: a slipping spring damps most between',
        'joint_stiffness': 'a third, larger level: what slips no longer stiffens',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per flexible joint."""
        return [cls(*place) for place in scene.joint_places]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return how stiff it is and where it slips, then how sharply."""
        first = (
            EffectParameter('share', '1', 0.3, 0.0, 5.0),
            EffectParameter('limit', 'rad', 1.0, 1e-7, 5e-3, neutral=4e-5, log=True),
        )
        knee = EffectParameter('knee', '1', 1.0, 0.7, 40.0, neutral=KNEE, log=True)
        return (*first, knee) if self.details else first

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the torque."""
        force = JointForce(self.place, HysteresisLaw, (*values, KNEE)[:3])
        return dataclasses.replace(cell, forces=(*cell.forces, force))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return limits over three decades."""
        return [(0.3, limit) for limit in (4e-7, 4e-6, 4e-5, 2e-4)]

    def other_starts(self, values: tuple[float, ...]) -> Sequence[tuple[float, ...]]:
        """Return limits far from each other: what never slips is a spring, the rest friction."""
        share, limit, *knee = values
        return [(share, limit * factor, *knee) for factor in (0.3, 3.0)]
