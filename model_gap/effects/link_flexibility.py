"""A link bends or twists."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from modal_core.channel import AXES
from model_gap.cell import CellModel
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from model_gap.effects.places import spans, stiffest, turned, unused_name
from structural_model.description import HingeSpec, Spring

# Of the link: a hinge whose axis leaves it by less may be anywhere along it.
LEAST_ACROSS = 1e-3


class LinkFlexibility(DetailedEffect):
    """A virtual hinge half-way along the link, about one of its axes.

    ``place`` (0 at its own joint, 1 at the next), the share of the mass beyond it and small turns
    of the axis are free once a fit is good.
    """

    type = 'link_flexibility'
    equation = 'virtual hinge with 1/k = c about one axis of the link'
    source = 'virtual joints; Mousavi et al. (2018), doi:10.1007/s00170-017-0052-0'
    turns = ('turn_1', 'turn_2')
    signature = 'relative motion inside one link, out of reach of the joints'
    says = '{place} bends, and the model has it stiff'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'turn the next joint by 90°: its axis leaves the bending plane',
        'base_compliance': 'two sensors on the link, one at each end',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per axis of every link with a span."""
        return [
            cls(link, axis) for link in spans(scene) if not _divided(scene, link) for axis in AXES
        ]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the compliance and how lossy it is."""
        unit = 0.3 / stiffest(scene)
        first = (
            EffectParameter('compliance', 'rad/(N m)', 15.0 * unit, 0.0, 300.0 * unit),
            EffectParameter('loss_time', 's', 0.7, 1e-5, 1e-2, neutral=4e-4, log=True),
        )
        if not self.details:
            return first
        return (
            *first,
            *self._place(scene),
            EffectParameter('outboard_share', '1', 0.25, 0.0, 1.0, neutral=0.5),
            EffectParameter('turn_1', 'rad', 0.3, -1.0, 1.0),
            EffectParameter('turn_2', 'rad', 0.3, -1.0, 1.0),
        )

    def probe(self, cell: CellModel, scene: Scene) -> tuple[CellModel, str] | None:
        """Return the hinge, all but rigid."""
        stiff = (1e-4 * 0.3 / stiffest(scene), 4e-4)
        divided = self.apply(cell, stiff, scene)
        return divided, divided.spec.hinges[-1].name

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Divide the link."""
        compliance, loss = max(values[0], 1e-14), values[1]
        place, share, *turns = self._details(values, scene)
        x, y, z = spans(scene)[str(self.location)]
        hinge = HingeSpec(
            name=unused_name(f'gap_{self.location}_{self.variant}', cell.spec.hinges),
            link=str(self.location),
            position_m=(place * x, place * y, place * z),
            axis=turned(self.variant, turns),
            spring=Spring(1.0 / compliance, loss / compliance),
            outboard_share=share,
        )
        return cell.with_spec(dataclasses.replace(cell.spec, hinges=(*cell.spec.hinges, hinge)))

    def _place(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return where along the link: nowhere in particular if the hinge turns along it."""
        span = np.array(spans(scene)[str(self.location)])
        across = np.linalg.norm(np.cross(span, AXES[self.variant]))
        if across < LEAST_ACROSS * np.linalg.norm(span):
            return ()
        return (EffectParameter('place', '1', 0.25, 0.0, 1.0, neutral=0.5),)

    def _details(self, values: Sequence[float], scene: Scene) -> tuple[float, ...]:
        if not self.details:
            return 0.5, 0.5, 0.0, 0.0
        return tuple(values[2:]) if self._place(scene) else (0.5, *values[2:])

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return compliances over three decades."""
        unit = 0.3 / stiffest(scene)
        return [(float(unit * f), 4e-4) for f in np.geomspace(0.02, 60.0, 16)]


def _divided(scene: Scene, link: str) -> bool:
    spec = scene.cell.spec
    taken = [item.link for item in spec.beams] + [item.link for item in spec.hinges]
    return link in taken
