"""Something hangs on a link and swings: dress pack, hose, cable."""

from collections.abc import Mapping, Sequence
import dataclasses
import math
from typing import ClassVar

import numpy as np
import pinocchio as pin

from modal_core.channel import AXES
from model_gap.cell import CellModel, Nuisance
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from model_gap.effects.payload import Payload
from model_gap.effects.places import (
    arm_mass,
    body_of,
    centre,
    moving_links,
    on_link,
    turned,
    unused_name,
)
from structural_model.description import AbsorberSpec, Spring


class TunedMass(DetailedEffect):
    """A mass m on a spring at a link: K = m ω_t², C = 2 ζ_t m ω_t.

    It hangs at the link's centre of mass and swings along one of its axes until a good fit frees
    place and direction; where a place was sought, it begins there with both free.
    """

    type = 'tuned_mass'
    equation = "m (z'' + a'') + 2 ζ m ω z' + m ω² z = 0 along one axis of the link"
    source = 'Den Hartog (1956), Mechanical Vibrations, sec. 3.2'
    point = ('at_x', 'at_y', 'at_z')
    turns = ('turn_1', 'turn_2')
    hangs = True
    signature = 'an extra mode or notch at the same frequency in every pose'
    says = 'A mass of {mass:.3g} kg swings on {place} at {frequency:.3g} Hz'
    confused_with: ClassVar[Mapping[str, str]] = {
        'payload': 'tie the hose down: a payload stays, a swinging mass does not',
        'link_flexibility': 'a pose with another reach: the notch of a swinging mass stays',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per moving body and axis."""
        sought = {(item.link, item.axis) for item in scene.hanging}
        return [
            cls(link, axis, details=(link, axis) in sought)
            for link in moving_links(scene)
            for axis in AXES
        ]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return mass, frequency and damping."""
        unit = max(1.0, 0.03 * arm_mass(scene))
        first = (
            EffectParameter('mass', 'kg', unit, 0.0, 10.0 * unit),
            EffectParameter('frequency', 'Hz', 0.8, 2.0, 70.0, neutral=15.0, log=True),
            EffectParameter('damping_ratio', '1', 0.8, 0.002, 0.5, neutral=0.04, log=True),
        )
        if not self.details:
            return first
        return (
            *first,
            *(
                EffectParameter(f'at_{axis}', 'm', 0.2, place - 0.8, place + 0.8, neutral=place)
                for axis, place in zip('xyz', centre(scene, str(self.location)), strict=True)
            ),
            EffectParameter('turn_1', 'rad', 0.4, -1.2, 1.2),
            EffectParameter('turn_2', 'rad', 0.4, -1.2, 1.2),
        )

    def probe(self, cell: CellModel, scene: Scene) -> tuple[CellModel, str] | None:
        """Return the place the mass pulls at: a mass too light to matter."""
        _, _, _, *place = self.starts(scene)[0]
        hung = self.apply(cell, (1e-4, 20.0, 0.05, *place), scene)
        return hung, hung.spec.absorbers[-1].name

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Hang the mass on the link."""
        mass, frequency, damping = max(values[0], 1e-6), values[1], values[2]
        x, y, z = values[3:6] if self.details else centre(scene, str(self.location))
        omega = 2.0 * math.pi * frequency
        item = AbsorberSpec(
            name=unused_name(f'swing_{self.location}_{self.variant}', cell.spec.absorbers),
            link=str(self.location),
            position_m=(x, y, z),
            axis=turned(self.variant, values[6:] if self.details else (0.0, 0.0)),
            mass_kg=mass,
            spring=Spring(mass * omega**2, 2.0 * damping * mass * omega),
        )
        return cell.with_spec(
            dataclasses.replace(cell.spec, absorbers=(*cell.spec.absorbers, item))
        )

    def simpler(self, values: tuple[float, ...], scene: Scene) -> tuple[Effect, tuple[float, ...]]:
        """Return a mass fixed where it hangs: what swings faster than all else follows."""
        link = str(self.location)
        here = body_of(scene, link)
        fixed = next(
            item for item in Payload.instances(scene) if body_of(scene, str(item.location)) == here
        )
        point = values[3:6] if self.details else centre(scene, link)
        pose = pin.neutral(scene.model.robot.model)
        at = on_link(scene, point, link, str(fixed.location), pose)
        rest = (item.neutral for item in fixed.parameters(scene)[4:])
        return fixed, (values[0], *at, *rest)

    def instead_of(
        self, tolerance: Nuisance, deviations: float, scene: Scene
    ) -> Sequence[Sequence[float]]:
        """Return slow and fast where the link's mass is far off.

        Below its own frequency what swings is a mass.
        """
        mass = tolerance.what == 'mass' and tolerance.link == self.location
        return self.few_starts(scene) if mass else ()

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return where it was sought, else frequencies over the band at the link's centre."""
        if not self.details:
            return swinging(scene)
        found = [
            (item.mass_kg, item.frequency_hz, item.damping_ratio, *item.point, 0.0, 0.0)
            for item in scene.hanging
            if (item.link, item.axis) == (self.location, self.variant)
        ]
        place = (*centre(scene, str(self.location)), 0.0, 0.0)
        return found or [(*start, *place) for start in swinging(scene)]


def swinging(scene: Scene) -> list[tuple[float, float, float]]:
    """Return mass, frequency and damping of what may hang on an arm: frequencies over the band."""
    mass = max(0.3, 0.01 * arm_mass(scene))
    return [(mass, float(f), 0.05) for f in np.geomspace(4.0, 50.0, 14)]
