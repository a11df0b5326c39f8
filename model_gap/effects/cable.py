"""A cable or hose pulls at a link: a spring to the ground."""

from collections.abc import Mapping, Sequence
import dataclasses
from typing import ClassVar

import numpy as np

from modal_core.channel import AXES
from model_gap.cell import CellModel
from model_gap.effects.effect import (
    DetailedEffect,
    Effect,
    EffectParameter,
    Scene,
    ToldNumber,
)
from model_gap.effects.places import (
    centre,
    centre_at_zero,
    moving_links,
    Place,
    reach,
    stiffest,
    turned,
    unused_name,
)
from structural_model.description import CableSpec

# Over the reach: from such an end, ten thousand reaches away, the line turns by 0.1 mrad on the
# whole way of the arm; nought would be no place.
LEAST_NEARNESS = 1e-4


class Cable(DetailedEffect):
    """K += k rᵀr - T ∂r/∂q, r how it shortens between a point of the link and one of the ground.

    In one pose an anchor and its mirror image beyond the link pull alike.  What tells them apart
    is how the line turns from pose to pose, and that goes with 1 / distance, through nought to
    the other side.  So an anchor is sought by direction and signed nearness: one optimum, where
    one sought as a point has two with infinity between them.

    It is fixed at the link's centre of mass, and does not pull at rest, until a good fit frees
    where it is and its steady pull T.

    Parameters
    ----------
    location : str
        Link.
    variant : str
        None.
    details : bool
        Whether where on the link it is fixed, and its pull, are free.
    along : str
        Axis of the base that its direction is turned from.

    References
    ----------
    Civera, Davison and Montiel (2008), doi:10.1109/TRO.2008.2003276, for the inverse distance.
    """

    type = 'cable'
    equation = (
        'force on a link -k (δ·n) n - T δ⊥ / L; n towards the anchor, δ all motion, motors too'
    )
    source = 'straight spring between two points; Irvine (1981), Cable Structures, ch. 1'
    point = ('at_x', 'at_y', 'at_z')
    signature = 'stiffer in some poses: also slow motion of the motors is held back at one link'
    # It pulls the wrong way until its direction has turned: worse at first from most sides.
    first_steps = 7
    says = 'A cable or hose holds {place} with {stiffness:.3g} N/m'
    confused_with: ClassVar[Mapping[str, str]] = {
        'joint_stiffness': 'take the cable off and repeat one pose',
        'tuned_mass': 'take the cable off and repeat one pose',
        'gravity_compensator': 'turn joint 1: a counterbalance turns with it, a cable does not',
    }

    def __init__(
        self,
        location: str | None = None,
        variant: str = '',
        details: bool = False,
        *,
        along: str = 'z',
    ) -> None:
        super().__init__(location, variant, details)
        self.along = along

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per moving link and axis that its direction is turned from."""
        return [cls(link, along=axis) for link in moving_links(scene) for axis in AXES]

    def detailed(self) -> Effect | None:
        """Return it with its pull and where on the link it is fixed free, None when they are."""
        if self.details:
            return None
        return Cable(self.location, self.variant, details=True, along=self.along)

    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the stiffness, which way it goes and how near its end is; below 0: behind.

        Priors as wide as what is plausible: stiffness and lever are told by their product first,
        and a narrow prior pulls along that line: stiffness by up to seven deviations.
        """
        unit, near = 0.01 * stiffest(scene), 2.0 / reach(scene)
        first = (
            EffectParameter('stiffness', 'N/m', 20.0 * unit, 0.0, 200.0 * unit),
            EffectParameter('turn_1', 'rad', 0.5, -1.2, 1.2),
            EffectParameter('turn_2', 'rad', 0.5, -1.2, 1.2),
            EffectParameter('nearness', '1/m', near, -5.0 * near, 5.0 * near),
        )
        if not self.details:
            return first
        return (
            *first,
            *(
                EffectParameter(f'at_{axis}', 'm', 0.2, place - 0.8, place + 0.8, neutral=place)
                for axis, place in zip('xyz', centre(scene, str(self.location)), strict=True)
            ),
            EffectParameter('pull', 'N', 300.0, 0.0, 3000.0),
        )

    def anchor(self, values: Sequence[float], scene: Scene) -> Place:
        """Return where on the ground it is fixed [m]."""
        least = LEAST_NEARNESS / reach(scene)
        nearness = values[3] if abs(values[3]) > least else least
        way = np.array(turned(self.along, values[1:3])) / nearness
        x, y, z = np.array(centre_at_zero(scene, str(self.location))) + way
        return float(x), float(y), float(z)

    def told(self, values: Sequence[float], scene: Scene) -> tuple[ToldNumber, ...]:
        """Return the stiffness and both ends, which people can look for."""
        ends = zip('xyz', self.anchor(values, scene), strict=True)
        first, *rest = super().told(values, scene)
        return (first, *(ToldNumber(f'from_{axis}', 'm', end) for axis, end in ends), *rest[3:])

    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Add the cable."""
        at = values[4:7] if self.details else centre(scene, str(self.location))
        cable = CableSpec(
            name=unused_name(f'gap_cable_{self.location}', cell.spec.cables),
            link=str(self.location),
            position_m=(at[0], at[1], at[2]),
            anchor_m=self.anchor(values, scene),
            stiffness_n_m=values[0],
            pull_n=values[7] if self.details else 0.0,
        )
        return cell.with_spec(dataclasses.replace(cell.spec, cables=(*cell.spec.cables, cable)))

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return soft and stiff ones from far away: how near is the fit's."""
        unit = 0.01 * stiffest(scene)
        ways = ((0.0, 0.0), (0.6, 0.6), (0.6, -0.6))
        return [(size * unit, *way, 0.0) for way in ways for size in (0.3, 3.0)]

    def few_starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return none beside what screened best: from every axis the fit comes to the same."""
        return ()
