"""The foundation tilts."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.setup import Setup
from structural_model.spec import Spring

ROCKING = (3, 4)


class BaseCompliance(Effect):
    """Two rocking degrees of freedom under the base, in series with those the model has."""

    type = 'base_compliance'
    equation = '1/k_rx += c, 1/k_ry += c, with loss time t: d = t/c'
    source = 'foundation stiffness of machine tools; Rivin (1999), Stiffness and Damping'
    signature = 'sensors on link 1 tilt in directions joint 1 cannot produce; depends on azimuth'
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
        unit = 0.3 / softest(scene)
        return (
            EffectParameter('compliance', 'rad/(N m)', unit, 0.0, 100.0 * unit),
            EffectParameter('loss_time', 's', 0.7, 1e-5, 1e-2, neutral=4e-4, log=True),
        )

    def apply(self, setup: Setup, values: Sequence[float], scene: Scene) -> Setup:
        """Add the compliance in series."""
        compliance, loss = max(values[0], 1e-14), values[1]
        springs = list(setup.spec.base.springs)
        for number in ROCKING:
            springs[number] = series(springs[number], compliance, loss)
        base = dataclasses.replace(
            setup.spec.base,
            springs=tuple(springs),  # type: ignore[arg-type]
        )
        return setup.with_spec(dataclasses.replace(setup.spec, base=base))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return compliances over two decades."""
        unit = 0.3 / softest(scene)
        return [(float(unit * f), 4e-4) for f in np.geomspace(0.01, 20.0, 24)]


def series(spring: Spring, compliance: float, loss_s: float) -> Spring:
    """Put a lossy compliance in series with a spring."""
    added = Spring(1.0 / compliance, loss_s / compliance)
    if spring.rigid:
        return added
    stiffness = 1.0 / (1.0 / spring.stiffness + compliance)
    return Spring(stiffness, spring.damping * stiffness / spring.stiffness)


def softest(scene: Scene) -> float:
    """Return the stiffness of the stiffest drive [N m/rad], the scale of the structure."""
    return max(
        item.drive.spring.stiffness
        for item in scene.setup.spec.joints
        if not item.drive.spring.rigid
    )
