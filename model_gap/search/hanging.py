"""Where a mass may hang and swing: points of every link, axes, frequencies, tried before any fit.

A fit finds its way from a point near by.  From the link's centre of mass, on the other side of a
joint's axis, it goes to no mass at all; and where place and direction are held there, even what
hangs near by hardly gains.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import itertools

import numpy as np

from modal_core.channel import AXES
from modal_core.work.side_by_side import side_by_side
from model_gap.effects import centre, Hanging, moving_links, reach, swinging
from model_gap.fit import tolerance_columns
from model_gap.hypothesis import Hypothesis
from model_gap.predict import at_point, hung, link_motions, Predictor
from model_gap.search.screen import growth_of, Projection

Place = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class HangingLimits:
    """Which places are tried; chosen, not measured, but for the last.

    Parameters
    ----------
    apart : float
        Of the arm's reach, from the link's centre to places before, behind and beside it.
    kept : int
        So many places of every link and axis are begun from.
    least_mass : float
        Of what was tried: what a fit learns of a place goes with the mass there. Of a made mass
        worth 44 units of log evidence 8 were found with 0.02, 42 with 0.3, 40 with 1.
    """

    apart: float = 0.1
    kept: int = 2
    least_mass: float = 0.3


LIMITS = HangingLimits()


def hanging(base: Hypothesis, predictor: Predictor) -> tuple[Hanging, ...]:
    """Return the masses that would explain most of what a hypothesis leaves over.

    Parameters
    ----------
    base : Hypothesis
        What they would be added to.
    predictor : Predictor
        Of a few records: one level is enough.

    Returns
    -------
    tuple of Hanging
        A few of every link and axis, the best first.
    """
    projection = Projection.of(base, predictor, tolerance_columns(base, predictor))
    links = moving_links(base.scene)

    def best_of(link: str) -> list[Hanging]:
        return _on_link(link, projection, predictor)

    return tuple(itertools.chain.from_iterable(side_by_side(best_of, links)))


def _on_link(link: str, projection: Projection, predictor: Predictor) -> list[Hanging]:
    """Return the best places of a link for each of its axes, each with its best frequency."""
    base = projection.base
    cell, scene = base.cell(), base.scene
    solved, masses = predictor.solved(cell), swinging(scene)
    (mass, _, damping), *_ = masses
    frequencies = np.array([frequency for _, frequency, _ in masses])
    motions = link_motions(cell, predictor, link)
    found: dict[str, list[tuple[float, Hanging]]] = {axis: [] for axis in AXES}
    for point in _places(centre(scene, link), LIMITS.apart * reach(scene)):
        there = [motion.through(at_point(point)) for motion in motions]
        for axis, along in AXES.items():
            changes = [
                hung(motion, item.omega[:, 1], mass, np.array(along), frequencies, damping)
                for motion, item in zip(there, predictor.records, strict=True)
            ]
            values = [
                projection.value(predictor.weighting.rows(predictor.seen_changes(solved, change)))
                for change in zip(*changes, strict=True)
            ]
            best = int(np.argmin([value for value, _ in values]))
            value, amplitude = values[best]
            size = mass * max(growth_of(amplitude), LIMITS.least_mass)
            frequency = float(frequencies[best])
            found[axis].append((value, Hanging(link, axis, point, size, frequency, damping)))
    return [
        item
        for places in found.values()
        for _, item in sorted(places, key=lambda place: place[0])[: LIMITS.kept]
    ]


def _places(middle: Place, apart: float) -> Sequence[Place]:
    """Return a point and those before, behind and beside it."""
    steps = [np.zeros(3), *(sign * apart * axis for axis in np.eye(3) for sign in (1.0, -1.0))]
    points = (np.array(middle) + step for step in steps)
    return [(float(x), float(y), float(z)) for x, y, z in points]
