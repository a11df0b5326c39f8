"""A cable or hose pulls at a link: a spring to the ground."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from model_gap.cell import CellModel
from model_gap.effects.effect import DetailedEffect, Effect, EffectParameter, Scene
from model_gap.effects.places import centre, moving_links, reach, spans, stiffest, unused_name
from structural_model.spec import CableSpec

# Where it may come from, in lengths from joint to joint: above, left, right, behind, ahead.
SIDES = ((0.3, 0.0, 1.3), (0.3, 1.3, 0.5), (0.3, -1.3, 0.5), (-1.3, 0.0, 0.5), (1.6, 0.0, 0.5))


class Cable(DetailedEffect):
    """K += k rᵀr, r how the distance from a point of the link to one of the ground changes.

    It is fixed at the link's centre of mass until a good fit frees where.
    """

    type = 'cable'
    equation = 'force on a link k (δ·n) n; n towards the anchor, δ all motion, the motors too'
    source = 'straight spring between two points; Irvine (1981), Cable Structures, ch. 1'
    signature = 'stiffer in some poses: also slow motion of the motors is held back at one link'
    on_links = True
    # It pulls the wrong way until its direction has turned: worse at first from most sides.
    first_steps = 7
    says = 'A cable or hose holds {place} with {stiffness:.3g} N/m'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'take the cable off and repeat one pose',
        'tuned_mass': 'take the cable off and repeat one pose',
        'gravity_compensator': 'turn joint 1: a counterbalance turns with it, a cable does not',
    }

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per moving link."""
        return [cls(link) for link in moving_links(scene)]

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the stiffness, and where it comes from."""
        unit, length = 0.01 * stiffest(scene), _length(scene)
        farthest = 4.0 * reach(scene)
        ends = [
            EffectParameter(f'from_{axis}', 'm', length, -farthest, farthest, start * length)
            for axis, start in zip('xyz', SIDES[0], strict=True)
        ]
        first = (EffectParameter('stiffness', 'N/m', unit, 0.0, 200.0 * unit), *ends)
        if not self.details:
            return first
        return (
            *first,
            *(
                EffectParameter(f'at_{axis}', 'm', 0.2, place - 0.8, place + 0.8, neutral=place)
                for axis, place in zip('xyz', centre(scene, str(self.location)), strict=True)
            ),
        )

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the cable."""
        anchor = values[1:4]
        at = values[4:] if self.details else centre(scene, str(self.location))
        cable = CableSpec(
            name=unused_name(f'gap_cable_{self.location}', cell.spec.cables),
            link=str(self.location),
            position_m=(at[0], at[1], at[2]),
            anchor_m=(anchor[0], anchor[1], anchor[2]),
            stiffness_n_m=values[0],
        )
        return cell.with_spec(dataclasses.replace(cell.spec, cables=(*cell.spec.cables, cable)))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return a soft and a stiff one from every side."""
        unit, length = 0.01 * stiffest(scene), _length(scene)
        return [
            (size * unit, *(part * length for part in side))
            for side in SIDES
            for size in (0.3, 3.0)
        ]

    def few_starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return soft ones from above and behind: the rest of the way is the fit's."""
        return [self.starts(scene)[2 * number] for number in (0, 3)]


def _length(scene: Scene) -> float:
    """Return the length of the arm from joint to joint [m]: starts that are near find more.

    From starts at its reach a fit came to rest at the mirror image of a cable that it had found.
    """
    return float(sum(np.linalg.norm(way) for way in spans(scene).values())) or 1.0
