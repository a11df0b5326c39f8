"""The servo gives way: the motor deviates from its command."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.nuisance import change_joint
from model_gap.setup import Setup
from structural_model.spec import JointSpec, Spring


class ServoCompliance(Effect):
    """A motor with the servo's own resonance f_s, ζ_s behind each gear."""

    type = 'servo_compliance'
    equation = "J θ'' + 2 ζ ω_s J θ' + J ω_s² θ = gear torque"
    source = 'Spong (1987), doi:10.1115/1.3143860'
    signature = 'all joints look softer and a damped extra mode appears; depends on servo gains'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'brakes on instead of servo: the drive springs stay'
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one for all drives, where rotor inertias are known."""
        known = all(
            item.drive.rotor_inertia_kg_m2 > 0.0 and item.drive.servo.rigid
            for item in scene.setup.spec.joints
        )
        return [cls(None)] if known else []

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return frequency and damping of the servo."""
        return (
            EffectParameter('frequency', 'Hz', 1.5, 3.0, 400.0, neutral=60.0, log=True),
            EffectParameter('damping_ratio', '1', 0.8, 0.02, 3.0, neutral=0.5, log=True),
        )

    def apply(self, setup: Setup, values: Sequence[float], scene: Scene) -> Setup:
        """Give every flexible drive a servo."""
        omega, damping = 2.0 * np.pi * values[0], values[1]
        spec = setup.spec
        for joint in scene.flexible_joints:

            def change(item: JointSpec) -> JointSpec:
                inertia = item.drive.rotor_inertia_kg_m2 * item.drive.gear_ratio**2
                servo = Spring(inertia * omega**2, 2.0 * damping * inertia * omega)
                return dataclasses.replace(
                    item, drive=dataclasses.replace(item.drive, servo=servo)
                )

            spec = change_joint(spec, joint, change)
        return setup.with_spec(spec)

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return frequencies over the band and above."""
        return [(float(f), z) for f in (8, 12, 18, 25, 35, 50, 75, 120) for z in (0.2, 0.7)]
