"""A mass the model does not know: tool, payload, forgotten adapter, equipment on the arm."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

from model_gap.cell import CellModel, Nuisance
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from model_gap.effects.places import arm_mass, body_of, centre, moving_links, Place, unused_name
from structural_model.description import MassSpec


class Payload(DetailedEffect):
    """M += m AᵀA + I JᵀJ at one link, usually the last.

    It turns as hard about every axis until a good fit frees the ratios: where tools are not round
    and this is not said, their centre of mass moves to make up for it.
    """

    type = 'payload'
    equation = 'M += m AᵀA + m Jᵀ diag(r²) J, A = J_v - [c]× J_w at the link'
    source = 'rigid-body inertia at the flange; Swevers et al. (1997), doi:10.1109/70.631234'
    shown_at = 'flange'
    point = ('com_x', 'com_y', 'com_z')
    signature = 'all modes that move the flange fall, by reach; shapes nearly kept'
    says = '{place} carries {mass:+.3g} kg that the model does not have'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'a folded and an extended pose: a mass acts by its lever arm',
        'link_flexibility': 'record with a known mass added to the flange',
        'sensor_mass': 'move the sensor to the neighbouring link',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one at the last link and one at every other moving body."""
        last = scene.model.link_names[-1]
        own = body_of(scene, last)
        others = [link for link in moving_links(scene) if body_of(scene, link) != own]
        return [cls(last), *(cls(link) for link in reversed(others))]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return mass, centre of mass and radius of gyration; its ratios between the axes."""
        total = max(1.0, 0.05 * arm_mass(scene))
        first = (
            EffectParameter('mass', 'kg', total, -4.0 * total, 8.0 * total),
            *(
                EffectParameter(f'com_{axis}', 'm', 0.15, place - 0.6, place + 0.6, neutral=place)
                for axis, place in zip('xyz', self._middle(scene), strict=True)
            ),
            EffectParameter('gyration', 'm', 0.05, 0.0, 0.4, neutral=0.06),
        )
        if not self.details:
            return first
        return (
            *first,
            *(
                EffectParameter(f'gyration_{axis}_over_x', '1', 0.5, 0.2, 5.0, 1.0, log=True)
                for axis in 'yz'
            ),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Fix the mass to the link."""
        mass, x, y, z, radius = values[:5]
        about_y, about_z = values[5:] if self.details else (1.0, 1.0)
        radius = radius if mass > 0.0 else 0.0
        item = MassSpec(
            name=unused_name(f'gap_{self.type}_{self.location}', cell.spec.masses),
            link=str(self.location),
            mass_kg=mass,
            position_m=(x, y, z),
            gyration_m=(radius, radius * about_y, radius * about_z),
        )
        return cell.with_spec(dataclasses.replace(cell.spec, masses=(*cell.spec.masses, item)))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return masses at a few places, at its centre on a link that is not the last."""
        if self.location != scene.model.link_names[-1]:
            return self.few_starts(scene)
        unit = max(1.0, 0.05 * arm_mass(scene))
        x, y, z = self._middle(scene)
        places = [(x, y, z), (x + 0.15, y, z), (x, y, z + 0.15)]
        return [
            (factor * unit, *place, 0.06)
            for factor in (-0.6, -0.3, 0.15, 0.35, 0.6, 0.9, 1.3, 1.8, 2.5, 3.5)
            for place in places
        ]

    def few_starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return light and heavy."""
        unit = max(1.0, 0.05 * arm_mass(scene))
        place = self._middle(scene)
        return [(factor * unit, *place, 0.06) for factor in (-0.1, 0.15, 0.6, 1.5)]

    def instead_of(
        self, tolerance: Nuisance, deviations: float, scene: Scene
    ) -> Sequence[Sequence[float]]:
        """Return light and heavy where the link's mass, or where it is, is far off."""
        here = body_of(scene, str(self.location))
        mass = tolerance.what == 'mass' and body_of(scene, tolerance.link) == here
        return self.few_starts(scene) if mass else ()

    def _middle(self, scene: Scene) -> Place:
        """Return where a mass is looked for first: the last link's origin, a link's own centre."""
        link = str(self.location)
        return (0.0, 0.0, 0.0) if link == scene.model.link_names[-1] else centre(scene, link)
