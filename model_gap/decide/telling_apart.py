"""What a campaign can tell apart before anything is found in it, and which recording adds most.

Every effect of a catalogue, at one plausible size, changes the spectra in one direction.  What
tolerances can do as well is projected out of it; what is left is what the evidence would see.  Two
effects are told apart where one of them leaves enough that the other, at any size, cannot do.
"""

from collections.abc import Sequence
import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Campaign, RecordSpectra
from model_gap.decide.directions import Directions, Size, Sized, Told
from model_gap.decide.discriminate import scaled_motion
from model_gap.effects import Effect
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from model_gap.search import EVIDENCE_BETWEEN, larger, SEARCH, Search

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sight:
    """One effect as a campaign sees it.

    Parameters
    ----------
    effect : Effect
        Of the catalogue.
    values : tuple of float
        The size it is looked at with.
    gain : float
        Log evidence it would gain.
    like : tuple of Effect
        What it could not be told from, of those that are seen.
    """

    effect: Effect
    values: tuple[float, ...]
    gain: float
    like: tuple[Effect, ...]


@dataclass(frozen=True)
class NextRecording:
    """A recording that could be made.

    Parameters
    ----------
    pose : (n_joints,) array [rad] or None
        Serial joints; None: the poses there are.
    factor : float
        Of the motion, that of the loudest recording.
    seen, told : int
        How many effects more it would show, and pairs more it would tell apart.
    """

    pose: Array | None
    factor: float
    seen: int
    told: int


@dataclass(frozen=True)
class Telling:
    """What a campaign can tell.

    Parameters
    ----------
    sights : tuple of Sight
        Every effect.
    worth_adding : float
        Log evidence from which an effect is seen.
    following : tuple of NextRecording
        The one that adds most first.
    """

    sights: tuple[Sight, ...]
    worth_adding: float
    following: tuple[NextRecording, ...]

    @property
    def unseen(self) -> tuple[Effect, ...]:
        """Effects that would gain too little to be named."""
        return tuple(item.effect for item in self.sights if item.gain < self.worth_adding)

    @property
    def alike(self) -> tuple[Sight, ...]:
        """Effects that are seen, but could not be told from another."""
        return tuple(it for it in self.sights if it.gain >= self.worth_adding and it.like)


def all_fitted(campaign: Campaign) -> Campaign:
    """Return a campaign of which no pose is held out."""
    records = tuple(dataclasses.replace(item, heldout=False) for item in campaign.records)
    return dataclasses.replace(campaign, records=records)


def telling_apart(search: Search, poses: Sequence[Array] = ()) -> Telling:
    """Return what the recordings of a search can tell apart.

    Parameters
    ----------
    search : Search
        As :meth:`Search.begin` gives it, of a campaign that is ``all_fitted``.
    poses : sequence of (n_joints,) array [rad]
        Where the loudest motion could be repeated.
    """
    predictor = search.data.screening
    present = search.nominal
    types = {kind.type for kind in search.settings.catalogue}
    effects = [
        effect
        for kind in search.settings.catalogue
        if kind.special_case not in types
        for effect in kind.instances(search.scene)
        if not effect.free_numbers  # what is fitted in every recording has no direction
    ]
    sizes = side_by_side(lambda effect: _sizes(effect, present, predictor), effects)
    sized = _of_one_effect(effects, sizes)
    now = Directions.of(sized, present, predictor)
    before = now.telling()
    least = search.settings.worth_adding
    sights = tuple(
        Sight(
            *sized[row][0],
            float(before.gain[row]),
            tuple(
                sized[column][0][0]
                for column in np.flatnonzero(before.apart[row] < EVIDENCE_BETWEEN)
                if column != row and before.gain[column] >= least
            ),
        )
        for row in range(len(sized))
    )
    following = [
        _worth(item, now, before, least, sized, present, predictor)
        for item in _possible(predictor, poses)
    ]
    found = [item for item in following if item is not None]
    found.sort(key=lambda item: (-item.told - item.seen, -item.told))
    return Telling(sights, least, tuple(found))


def _of_one_effect(
    effects: Sequence[Effect], sizes: Sequence[tuple[tuple[float, ...], ...]]
) -> list[tuple[Size, ...]]:
    """Return the sizes of each effect that has any, those of one begun from several sides joined.

    They are one name: a campaign need not tell them apart.
    """
    found: dict[tuple[str, str, str], list[Size]] = {}
    for effect, own in zip(effects, sizes, strict=True):
        found.setdefault((*effect.key, effect.variant), []).extend((effect, it) for it in own)
    return [tuple(some) for some in found.values() if some]


def _sizes(
    effect: Effect, present: Hypothesis, predictor: Predictor
) -> tuple[tuple[float, ...], ...]:
    """Return plausible sizes, the middle one first, made larger until they show."""
    starts = [tuple(start) for start in effect.starts(present.scene)]
    middle = len(starts) // 2
    chosen = dict.fromkeys((starts[middle], starts[0], starts[-1])) if starts else {}
    sizes = (_grown(effect, values, present, predictor) for values in chosen)
    return tuple(dict.fromkeys(size for size in sizes if size is not None))


def _grown(
    effect: Effect, values: tuple[float, ...], present: Hypothesis, predictor: Predictor
) -> tuple[float, ...] | None:
    """Return a size at which an effect shows; None of an impossible arm."""
    base = predictor.rows(present.cell())
    for _ in range(SEARCH.most_grown):
        try:
            change = predictor.rows(effect.apply(present.cell(), values, present.scene)) - base
        except ModelError:
            return None
        moved = float(np.sqrt(change @ change / predictor.weighting.count))
        new = larger(effect, values, present.scene)
        if moved > SEARCH.least_moved or new == values:
            break
        values = new
    return values


def _possible(
    predictor: Predictor, poses: Sequence[Array]
) -> list[tuple[Array | None, float, list[RecordSpectra]]]:
    """Return recordings that could be made: elsewhere, or louder and softer where it was."""
    records = predictor.records
    loudest = max(records, key=lambda item: float(np.abs(item.motor_acceleration).sum()))
    found: list[tuple[Array | None, float, list[RecordSpectra]]] = [
        (
            pose,
            1.0,
            [dataclasses.replace(loudest, record=dataclasses.replace(loudest.record, pose=pose))],
        )
        for pose in poses
    ]
    same = [item for item in records if item.record.level == loudest.record.level]
    return found + [(None, by, [scaled_motion(item, by) for item in same]) for by in (0.35, 2.0)]


def _worth(
    item: tuple[Array | None, float, list[RecordSpectra]],
    now: Directions,
    before: Told,
    least: float,
    sized: Sized,
    present: Hypothesis,
    predictor: Predictor,
) -> NextRecording | None:
    """Return what a recording would add; None of an impossible arm."""
    pose, factor, records = item
    there = dataclasses.replace(predictor, records=records)
    try:
        after = now.with_more(Directions.of(sized, present, there)).telling()
    except ModelError:
        return None
    seen = (after.gain >= least).sum() - (before.gain >= least).sum()
    both = np.outer(after.gain >= least, after.gain >= least) & ~np.eye(len(sized), dtype=bool)
    told = (both & (after.apart >= EVIDENCE_BETWEEN)).sum()
    told -= (both & (before.apart >= EVIDENCE_BETWEEN)).sum()
    return NextRecording(pose, factor, int(seen), int(told) // 2)
