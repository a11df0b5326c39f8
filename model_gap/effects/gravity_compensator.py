"""A spring or gas cylinder carries part of the arm's weight, and the model does not have it."""

from collections.abc import Mapping, Sequence
import dataclasses
import math
from typing import ClassVar

from model_gap.cell import CellModel
from model_gap.effects.effect import Effect, EffectParameter, Scene
from model_gap.effects.places import stiffest, unused_name
from structural_model.description import CompensatorSpec


class GravityCompensator(Effect):
    """τ_j += -κ sin(q_j - φ), as two numbers that act alike: κ cos φ and κ sin φ."""

    type = 'gravity_compensator'
    equation = 'τ_j += -κ sin(q_j - φ); K_jj += κ cos(q_j - φ); a = κ cos φ, b = κ sin φ'
    source = 'Klimchik et al. (2017), doi:10.1016/j.mechmachtheory.2016.12.002'
    signature = "one joint is stiffer or softer by where it stands, and by nothing else's pose"
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'the same joint at two angles 60° apart, all others as they were',
        'payload': 'turn the wrist: a payload follows, a counterbalance does not',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per joint that lifts the arm: the second and the third of those that turn."""
        return [
            cls(name) for name in scene.model.joint_names[1:3] if name in scene.flexible_joints
        ]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return its strength, split along the joint's zero and a right angle from it."""
        unit = 0.02 * stiffest(scene)
        return tuple(
            EffectParameter(name, 'N m', unit, -30.0 * unit, 30.0 * unit)
            for name in ('strength_cos', 'strength_sin')
        )

    @classmethod
    def in_words(cls, place: str, numbers: Mapping[str, float]) -> str:
        """Return strength and neutral angle."""
        along, across = numbers['strength_cos'], numbers['strength_sin']
        angle = math.degrees(math.atan2(across, along))
        size = math.hypot(along, across)
        return f'A counterbalance acts on {place}: {size:.3g} N m, neutral at {angle:.0f}°'

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the compensator."""
        item = CompensatorSpec(
            name=unused_name(f'gap_balance_{self.location}', cell.spec.compensators),
            joint=str(self.location),
            strength_nm=math.hypot(values[0], values[1]),
            phase_rad=math.atan2(values[1], values[0]),
        )
        compensators = (*cell.spec.compensators, item)
        return cell.with_spec(dataclasses.replace(cell.spec, compensators=compensators))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return weak and strong ones, neutral at four angles."""
        unit = 0.02 * stiffest(scene)
        return [
            (size * unit * c, size * unit * s)
            for size in (0.5, 3.0)
            for c, s in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
        ]
