"""A mass the model does not know, at the flange: tool, payload, forgotten adapter."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.setup import Setup
from structural_model.spec import MassSpec


class Payload(Effect):
    """M += m AᵀA + I JᵀJ at the last link."""

    type = 'payload'
    equation = 'M += m AᵀA + m r² JᵀJ, A = J_v - [c]× J_w at the flange'
    source = 'rigid-body inertia at the flange; Swevers et al. (1997), doi:10.1109/70.631234'
    signature = 'all modes that move the flange fall, by reach; shapes nearly kept'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'a folded and an extended pose: a mass acts by its lever arm',
        'link_flexibility': 'record with a known mass added to the flange',
        'sensor_mass': 'move the sensor to the neighbouring link',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one at the last link."""
        return [cls(scene.model.link_names[-1])]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return mass, centre of mass and radius of gyration."""
        total = max(1.0, 0.05 * arm_mass(scene))
        return (
            EffectParameter('mass', 'kg', total, -4.0 * total, 8.0 * total),
            EffectParameter('com_x', 'm', 0.15, -0.6, 0.6),
            EffectParameter('com_y', 'm', 0.15, -0.6, 0.6),
            EffectParameter('com_z', 'm', 0.15, -0.6, 0.6),
            EffectParameter('gyration', 'm', 0.05, 0.0, 0.4, neutral=0.06),
        )

    def apply(self, setup: Setup, values: Sequence[float], scene: Scene) -> Setup:
        """Fix the mass to the link."""
        mass, x, y, z, radius = values
        item = MassSpec(
            name=f'gap_{self.type}',
            link=str(self.location),
            mass_kg=mass,
            position_m=(x, y, z),
            gyration_m=(radius,) * 3 if mass > 0.0 else (0.0, 0.0, 0.0),
        )
        return setup.with_spec(dataclasses.replace(setup.spec, masses=(*setup.spec.masses, item)))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return masses at a few places."""
        unit = max(1.0, 0.05 * arm_mass(scene))
        places = [(0.0, 0.0, 0.0), (0.15, 0.0, 0.0), (0.0, 0.0, 0.15)]
        return [
            (factor * unit, *place, 0.06)
            for factor in (-0.6, -0.3, 0.15, 0.35, 0.6, 0.9, 1.3, 1.8, 2.5, 3.5)
            for place in places
        ]


def arm_mass(scene: Scene) -> float:
    """Return the mass of the moving links [kg]."""
    inertias = scene.model.robot.model.inertias
    return float(sum(inertias[index].mass for index in range(1, len(inertias))))
