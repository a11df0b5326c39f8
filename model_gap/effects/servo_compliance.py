"""The servo gives way: the motor deviates from its command."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.campaign import Complex
from model_gap.cell import CellModel, change_joint, Filter
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from structural_model.description import JointSpec, Spring


class ServoCompliance(DetailedEffect):
    """A motor with the servo's own resonance f_s, ζ_s behind each gear.

    What the servo feeds forward of the rotor's inertia (φ) and of its own damping (δ) is all until
    a fit is good.  What it does not makes the motor lag: the command behind the filter
    (φ s² + 2 δ ζ ω_s s + ω_s²)/(s² + 2 ζ ω_s s + ω_s²), the same in all joints.
    """

    type = 'servo_compliance'
    equation = (
        "J (θ'' - φ r'') + 2 ζ ω_s J (θ' - δ r') + J ω_s² (θ - r) = gear torque, r the command"
    )
    source = 'Spong (1987), doi:10.1115/1.3143860'
    signature = 'all joints look softer and a damped extra mode appears; depends on servo gains'
    says = 'The drives give way: they do not hold their motors still'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'brakes on instead of servo: the drive springs stay'
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one for all drives, where rotor inertias are known."""
        known = all(
            item.drive.rotor_inertia_kg_m2 > 0.0 and item.drive.servo.rigid
            for item in scene.cell.spec.joints
        )
        return [cls(None)] if known else []

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return frequency and damping of the servo, and what it feeds forward."""
        first = (
            EffectParameter('frequency', 'Hz', 1.5, 3.0, 400.0, neutral=60.0, log=True),
            EffectParameter('damping_ratio', '1', 0.8, 0.02, 3.0, neutral=0.5, log=True),
        )
        if not self.details:
            return first
        return (
            *first,
            EffectParameter('inertia_feedforward', '1', 1.0, -0.5, 1.5, neutral=1.0),
            EffectParameter('damping_feedforward', '1', 1.0, -0.5, 1.5, neutral=1.0),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Give every flexible drive a servo."""
        omega, damping = 2.0 * np.pi * values[0], values[1]
        spec = cell.spec
        for joint in scene.flexible_joints:

            def change(item: JointSpec) -> JointSpec:
                inertia = item.drive.rotor_inertia_kg_m2 * item.drive.gear_ratio**2
                servo = Spring(inertia * omega**2, 2.0 * damping * inertia * omega)
                return dataclasses.replace(
                    item, drive=dataclasses.replace(item.drive, servo=servo)
                )

            spec = change_joint(spec, joint, change)
        cell = cell.with_spec(spec)
        return cell.then_input(lag_step(omega, damping, *values[2:])) if self.details else cell

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return frequencies over the band and above."""
        return [(float(f), z) for f in (8, 12, 18, 25, 35, 50, 75, 120) for z in (0.2, 0.7)]


def lag_step(servo: float, damping: float, inertia: float, speed: float) -> Filter:
    """Return the filter of a command that is fed forward in part.

    Parameters
    ----------
    servo : float [rad/s]
        Natural frequency of the servo.
    damping : float
        Its damping ratio.
    inertia, speed : float
        Shares fed forward of the rotor's inertia and of the servo's damping.
    """

    def step(omega: np.ndarray, spectra: Complex) -> Complex:
        s = 1j * omega / servo
        fed = inertia * s**2 + 2.0 * speed * damping * s + 1.0
        return np.asarray(spectra * (fed / (s**2 + 2.0 * damping * s + 1.0)))

    return step
