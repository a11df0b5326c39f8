"""The drive of one joint is softer or stiffer than the model says."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel, change_drive, Nuisance
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from structural_model.description import Spring


class JointStiffness(DetailedEffect):
    """k_j → f·k_j, c_j → f^a·c_j; the loss factor is kept (a = 1) until a fit is good."""

    type = 'joint_stiffness'
    equation = 'k_j -> f k_j, c_j -> f^a c_j'
    source = 'Do et al. (2022); Klimchik et al. (2015), doi:10.1016/j.rcim.2015.01.003'
    signature = 'modes with strain energy in the joint shift, by their share; not by amplitude'
    confused_with: ClassVar[Mapping[str, str]] = {
        'payload': 'a folded and an extended pose: a mass acts by its lever arm',
        'base_compliance': 'turn joint 1 by 90°: the base axes stay, joint 2 turns with it',
        'link_flexibility': 'turn the next joint by 90°: its axis leaves the bending plane',
        'backlash': 'a second amplitude level: a spring keeps its frequency',
        'cubic_stiffness': 'a second amplitude level: a linear spring keeps its frequency',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per flexible joint."""
        return [cls(joint) for joint in scene.flexible_joints]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the factor."""
        first = EffectParameter('factor', '1', 0.7, 0.05, 5.0, neutral=1.0, log=True)
        exponent = EffectParameter('damping_exponent', '1', 0.6, -1.0, 3.0, neutral=1.0)
        return (first, exponent) if self.details else (first,)

    @classmethod
    def in_words(cls, place: str, numbers: Mapping[str, float]) -> str:
        """Return how much softer or stiffer."""
        change = 100.0 * (numbers['factor'] - 1.0)
        kind = 'softer' if change < 0.0 else 'stiffer'
        return f'{place} is {abs(change):.0f} % {kind} than the model says'

    def probe(self, cell: CellModel, scene: Scene) -> tuple[CellModel, str] | None:
        """Return the drive."""
        return cell, self.place

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Scale the drive spring."""
        factor, exponent = values if self.details else (values[0], 1.0)

        def change(spring: Spring) -> Spring:
            return Spring(spring.stiffness * factor, spring.damping * factor**exponent)

        return cell.with_spec(change_drive(cell.spec, str(self.location), change))

    def instead_of(
        self, tolerance: Nuisance, deviations: float, scene: Scene
    ) -> Sequence[Sequence[float]]:
        """Return the factor that the drive's tolerance has come to."""
        own = (tolerance.what, tolerance.joint) == ('stiffness', self.location)
        return [(float(np.exp(tolerance.sigma * deviations)),)] if own else ()

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return factors close enough together for a spectral fit."""
        return [(float(f),) for f in np.exp(np.arange(-1.6, 0.95, 0.1)) if abs(f - 1.0) > 0.01]
