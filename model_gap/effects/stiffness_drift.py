"""A drive grows softer, or stiffer, as time passes: it warms up."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from modal_core.work.compiled import compiled
from model_gap.cell import CellModel, JointForce
from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.laws import Array, JointContext, SpringLaw


@compiled
def drifted(
    constants: Array, memory: Array, twist: float, rate: float, motor_speed: float
) -> tuple[float, float]:
    """Return the torque of what the spring has gained by now."""
    added, per_step, give, least = constants[0], constants[1], constants[2], constants[3]
    stiffer = max(added + per_step * memory[0], least)
    memory[0] += 1.0
    return stiffer * twist / (1.0 + give * stiffer), 0.0


class DriftLaw(SpringLaw):
    """N = k ρ t e, t from the beginning of the campaign; value ρ [1/s]."""

    torque = drifted
    # Of the stiffness, that is left at least.
    least: ClassVar[float] = 0.1

    @classmethod
    def constants(cls, values: Sequence[float], context: JointContext) -> Sequence[float]:
        """Return what the spring has gained as the record begins, and gains with every step."""
        (speed,) = values
        per_second = context.stiffness * speed
        least = (cls.least - 1.0) * context.stiffness
        begun = per_second * context.start_s
        return begun, per_second * context.period_s, context.give, least


class StiffnessDrift(Effect):
    """k(t) = k (1 + ρ t), t from the beginning of the campaign."""

    type = 'stiffness_drift'
    equation = 'τ = k (1 + ρ t) e, t since the first recording began'
    source = 'ISO 230-3:2020, thermal drift of machines; here of a spring'
    signature = 'frequencies of one joint move with time, not with pose or amplitude'
    says = 'The stiffness of {place} changes with time, by {rate:.2g} of it in a second'
    amplitude_dependent = True
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'the first recording once more at the end: only drift has moved on',
        'cubic_stiffness': 'the loud recording first, then last: drift asks for time, not motion',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per flexible joint."""
        return [cls(*place) for place in scene.joint_places]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the relative change in a second."""
        return (EffectParameter('rate', '1/s', 3e-3, -0.03, 0.03),)

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the torque."""
        force = JointForce(self.place, DriftLaw, (values[0],))
        return dataclasses.replace(cell, forces=(*cell.forces, force))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return percents a quarter of an hour, and percents half a minute."""
        return [(sign * size,) for size in (5e-5, 4e-3) for sign in (-1.0, 1.0)]
