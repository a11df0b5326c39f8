"""The floor or block under the robot swings: a resonance that no link owns."""

from collections.abc import Mapping, Sequence
import dataclasses
import math
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from model_gap.effects.places import arm_mass
from structural_model.description import FoundationSpec, Spring

SLIDES = {'along x': (0,), 'along y': (1,), 'along z': (2,), 'along x and y': (0, 1)}
ROCKS = {'about x': (3,), 'about y': (4,), 'about x and y': (3, 4)}
WAYS = {**SLIDES, **ROCKS}
# Of a block that hardly gives way: its mobility, over the arm's own.
LEAST = 1e-6


class FoundationMode(DetailedEffect):
    """A body of mass m (inertia J when it rocks) under the base, on springs m ω², 2 ζ m ω.

    ``inverse_mass`` is 1/m, 1/J: nothing at 0.  Direction, height of the axis it rocks about and
    the frequency across are as they are thought of first until a fit is good.
    """

    type = 'foundation_mode'
    equation = "m (z'' + 2 ζ ω z' + ω² z) = F of the arm on its base; rocking: J, moment"
    source = 'Srinivasulu and Vaidyanathan (1976), Handbook of Machine Foundations, ch. 3'
    shown_at = 'base'
    signature = 'an extra mode at one frequency in every pose that moves the base plate too'
    says = 'The foundation swings at {frequency:.3g} Hz'
    confused_with: ClassVar[Mapping[str, str]] = {
        'base_compliance': 'a sensor on the base plate: below its resonance it swings alike',
        'tuned_mass': 'a sensor on the base plate: a hose does not move it',
        'tonal_disturbance': 'switch the excitation off: a resonance falls silent',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per way to swing; none where the model has a foundation already."""
        return [cls(None, way) for way in WAYS] if scene.cell.spec.foundation.rigid else []

    @property
    def ways(self) -> tuple[int, ...]:
        """Springs that give way."""
        return WAYS[self.variant]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return mobility, frequency and damping."""
        unit, of = 1.0 / arm_mass(scene), '1/(kg m²)' if self.variant in ROCKS else '1/kg'
        first = (
            EffectParameter('inverse_mass', of, unit, 0.0, 30.0 * unit),
            EffectParameter('frequency', 'Hz', 0.8, 2.0, 70.0, neutral=15.0, log=True),
            EffectParameter('damping_ratio', '1', 0.8, 0.002, 0.5, neutral=0.04, log=True),
        )
        if not self.details:
            return first
        more = []
        if len(self.ways) == 2:
            more.append(EffectParameter('across', '1', 0.4, 0.2, 5.0, neutral=1.0, log=True))
        elif self.ways != (2,):
            more.append(EffectParameter('yaw', 'rad', 0.5, -1.6, 1.6))
        if self.variant in ROCKS:
            more.append(EffectParameter('height', 'm', 0.5, -4.0, 2.0))
        return (*first, *more)

    def probe(self, cell: CellModel, scene: Scene) -> tuple[CellModel, str] | None:
        """Return the body, so heavy that it hardly swings; both ways are no one coordinate."""
        if len(self.ways) == 2:
            return None
        name = ('tx', 'ty', 'tz', 'rx', 'ry')[self.ways[0]]
        return self.apply(cell, (0.0, 15.0, 0.04), scene), f'foundation/{name}'

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Put the body under the base."""
        inverse, frequency, damping = values[:3]
        names = [item.name for item in self.parameters(scene)[3:]]
        detail = {
            'across': 1.0,
            'yaw': 0.0,
            'height': 0.0,
            **dict(zip(names, values[3:], strict=True)),
        }
        mass = 1.0 / max(inverse, LEAST / arm_mass(scene))
        springs = [Spring()] * 6
        for number, way in enumerate(self.ways):
            omega = 2.0 * math.pi * frequency * (detail['across'] if number else 1.0)
            springs[way] = Spring(mass * omega**2, 2.0 * damping * mass * omega)
        body = FoundationSpec(
            springs=tuple(springs),  # type: ignore[arg-type]
            mass_kg=mass,
            gyration_m=1.0,
            position_m=(0.0, 0.0, detail['height']),
            yaw_rad=detail['yaw'],
        )
        return cell.with_spec(dataclasses.replace(cell.spec, foundation=body))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return frequencies over the band, of a body of twice the arm's mass."""
        inverse = 0.5 / arm_mass(scene)
        return [(inverse, float(f), 0.04) for f in np.geomspace(5.0, 50.0, 14)]
