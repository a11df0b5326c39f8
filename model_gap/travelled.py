"""Recordings in which the joints travel too far to be compared with a model about one pose."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeGuard

import numpy as np

from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Band, Campaign
from model_gap.cell import CellModel
from model_gap.decide import adequacy, Decision, LIMITS, objections, Verdict
from model_gap.predict import Changing, changing, response_change
from model_gap.search import Search
from structural_model import FlexibleJointModel

# What a travel may add to χ, of all data and of one band: what is objected to less the noise.
MOST = LIMITS.misfit - 1.0
MOST_IN_A_BAND = LIMITS.worst_misfit - 1.0
# Recordings told by name.
NAMED = 4


@dataclass(frozen=True)
class Travelled:
    """Recordings whose joints travel too far.

    Parameters
    ----------
    names : tuple of str
        Which.
    joint, farthest : str
        The joint that travels farthest in any of them, and in which.
    travel, most : float
        How far from end to end, and how far it might [deg] or [mm].
    unit : str
        Of both.
    share : float
        By what share of itself the response changes on that way.
    all_of_them : bool
        No recording of the campaign is about one pose.
    """

    names: tuple[str, ...]
    joint: str
    farthest: str
    travel: float
    most: float
    unit: str
    share: float
    all_of_them: bool

    @property
    def words(self) -> str:
        """What of it, without a full stop."""
        more = len(self.names) - NAMED
        names = ', '.join(self.names[:NAMED]) + (f' and {more} more' if more > 0 else '')
        end = 'no recording is about one pose' if self.all_of_them else 'left out'
        return (
            f'the joints travel too far to be compared about one pose in {names}: up to '
            f'{self.travel:.3g} {self.unit} of {self.joint} in {self.farthest}, where the '
            f'response changes by {self.share:.0%} on the way; {end}'
        )

    @property
    def next_recording(self) -> str:
        """What to record instead."""
        return (
            f'record each pose with the joints shaking about it: {self.joint} may travel '
            f'{self.most:.2g} {self.unit} from end to end at most'
        )


def compares_none(travelled: Travelled | None) -> TypeGuard[Travelled]:
    """Tell whether no recording of a campaign is about one pose."""
    return travelled is not None and travelled.all_of_them


def without_travelled(
    model: FlexibleJointModel, campaign: Campaign, band: Band
) -> tuple[Campaign, Travelled | None]:
    """Return a campaign less the recordings whose joints travel too far, and which these are.

    Where that were all, all stay: how far they are off is told.
    """
    cell = CellModel(model.spec, campaign.layout.channels)
    found = side_by_side(lambda record: changing(record, model, cell, band), campaign.records)
    far = [item.misfit > MOST or item.worst_misfit > MOST_IN_A_BAND for item in found]
    if not any(far):
        return campaign, None
    kept = tuple(record for record, out in zip(campaign.records, far, strict=True) if not out)
    told = _told(model, cell, campaign, band, found, np.flatnonzero(far).tolist())
    notes = (*campaign.notes, told.words)
    return replace(campaign, records=kept or campaign.records, notes=notes), told


def _told(
    model: FlexibleJointModel,
    cell: CellModel,
    campaign: Campaign,
    band: Band,
    found: Sequence[Changing],
    far: Sequence[int],
) -> Travelled:
    # What travel adds to χ grows with its fourth power.
    room = [
        min(MOST / found[number].misfit, MOST_IN_A_BAND / found[number].worst_misfit) ** 0.25
        for number in far
    ]
    best = max(far, key=lambda number: float(found[number].travel.max()))
    joint = int(np.argmax(found[best].travel))
    slides = model.robot.joints[joint].prismatic
    scale = 1e3 if slides else np.degrees(1.0)
    most = min(
        float(found[number].travel.max()) * part for number, part in zip(far, room, strict=True)
    )
    record = campaign.records[best]
    return Travelled(
        names=tuple(campaign.records[number].name for number in far),
        joint=model.joint_names[joint],
        farthest=record.name,
        travel=float(found[best].travel[joint]) * scale,
        most=most * scale,
        unit='mm' if slides else 'deg',
        share=response_change(record, model, cell, band),
        all_of_them=len(far) == len(found),
    )


def with_travel(decision: Decision, search: Search, travelled: Travelled | None) -> Decision:
    """Return a verdict that names no effect where every recording's joints travel too far."""
    if not compares_none(travelled) or search.simulated:
        return decision
    why = objections(adequacy(search, search.rounds[0].before))
    if not why:
        return decision
    reasons = (travelled.words, *why)
    return Decision(Verdict.UNEXPLAINED, reasons=reasons, experiments=(travelled.next_recording,))
