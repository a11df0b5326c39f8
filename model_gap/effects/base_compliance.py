"""The foundation tilts."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel, Nuisance
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from model_gap.effects.places import stiffest
from structural_model.description import Spring

SIDEWAYS, ROCKING = (0, 1), (3, 4)


class BaseCompliance(DetailedEffect):
    """Two rocking degrees of freedom under the base, in series with those the model has.

    ``difference`` d and ``translation`` s are zero until a fit is good.
    """

    type = 'base_compliance'
    equation = '1/k_rx += c + d, 1/k_ry += c - d, damping t/c; sideways 1/k += s'
    source = 'foundation stiffness of machine tools; Rivin (1999), Stiffness and Damping'
    shown_at = 'base'
    signature = 'sensors on link 1 tilt in directions joint 1 cannot produce; depends on azimuth'
    says = 'The base gives way: the robot rocks on its foundation'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'turn joint 1 by 90°: the base axes stay, joint 2 turns with it',
        'link_flexibility': 'a sensor on the base plate',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one."""
        return [cls(None)]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the compliance and how lossy it is."""
        unit = 0.3 / stiffest(scene)
        first = (
            EffectParameter('compliance', 'rad/(N m)', 5.0 * unit, 0.0, 100.0 * unit),
            EffectParameter('loss_time', 's', 0.7, 1e-5, 1e-2, neutral=4e-4, log=True),
        )
        if not self.details:
            return first
        return (
            *first,
            EffectParameter('difference', 'rad/(N m)', unit, -100.0 * unit, 100.0 * unit),
            EffectParameter('translation', 'm/N', 0.1 * unit, 0.0, 10.0 * unit),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the compliance in series."""
        compliance, loss = values[0], values[1]
        difference, translation = values[2:] if self.details else (0.0, 0.0)
        springs = list(cell.spec.base.springs)
        for number, sign in zip(ROCKING, (1.0, -1.0), strict=True):
            own = max(compliance + sign * difference, 1e-14)
            springs[number] = series(springs[number], own, loss)
        if translation > 0.0:
            for number in SIDEWAYS:
                springs[number] = series(springs[number], translation, loss)
        base = dataclasses.replace(
            cell.spec.base,
            springs=tuple(springs),  # type: ignore[arg-type]
        )
        return cell.with_spec(dataclasses.replace(cell.spec, base=base))

    def instead_of(
        self, tolerance: Nuisance, deviations: float, scene: Scene
    ) -> Sequence[Sequence[float]]:
        """Return a few compliances where the model's own base is far too soft."""
        return self.few_starts(scene) if tolerance.what == 'base' and deviations < 0.0 else ()

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return compliances over two decades."""
        unit = 0.3 / stiffest(scene)
        return [(float(unit * f), 4e-4) for f in np.geomspace(0.01, 20.0, 24)]


def series(spring: Spring, compliance: float, loss_s: float) -> Spring:
    """Put a lossy compliance in series with a spring, to first order in the frequency.

    Compliances add, 1/(k + iωc) = (1 - iωτ)/k with the loss time τ = c/k: so do their losses.
    """
    if spring.rigid:
        return Spring(1.0 / compliance, loss_s / compliance)
    own = 1.0 / spring.stiffness
    stiffness = 1.0 / (own + compliance)
    lost_s = stiffness * (own * spring.damping / spring.stiffness + compliance * loss_s)
    return Spring(stiffness, stiffness * lost_s)
