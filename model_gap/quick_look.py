"""A first answer within seconds: healthy or not, and where; nothing is named.

Tolerances alone are fitted to the beginning of a few recordings.  What they cannot explain is a
gap; how far the tolerances went, and what is left over, say where it is.
"""

from dataclasses import dataclass, replace
from enum import Enum
from math import isfinite, sqrt
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from modal_core.work.progress import Progress
from modal_reports import FREQUENCY
from model_gap.campaign import Campaign
from model_gap.cell import in_words
from model_gap.decide import Adequacy, adequacy, AGREEING, objections, what_remains
from model_gap.fit import split
from model_gap.gravity import as_it_stands, Fault, left_open, put_right, rest_of, weigh
from model_gap.hypothesis import STRETCHED
from model_gap.modes import mode_pairs, ModePair
from model_gap.search import (
    evidence_bound,
    fit_tolerances,
    joint_shares,
    of_first_poses,
    Search,
    SearchSettings,
    shortened,
    tolerance_excess,
)
from model_gap.travelled import compares_none, Travelled, without_travelled
from structural_model import FlexibleJointModel


class State(Enum):
    """What a quick look says."""

    HEALTHY = 'healthy'
    UNCLEAR = 'unclear'
    GAP = 'gap'


@dataclass(frozen=True, slots=True)
class QuickLimits:
    """What a quick look sees, and what it says from.

    Parameters
    ----------
    fitted_poses, heldout_poses : int
        Of each at most so many.
    seconds : float [s]
        Of every recording.
    telling_share : float
        Of what is left over, that a torque in a joint must account for to be said; chosen.
    telling_sigma : float
        Standard deviations by which a mode must be off to be said: 0.3 % by chance.
    """

    fitted_poses: int = 3
    heldout_poses: int = 2
    seconds: float = 12.0
    telling_share: float = 0.3
    telling_sigma: float = 3.0


LIMITS = QuickLimits()
# Recordings that are read for a quick look: five poses at two levels.
READ = 10
# χ: what is left over below it is mostly noise, and describes nothing.
LEAST_TO_DESCRIBE = 1.5


@dataclass(frozen=True)
class QuickLook:
    """Healthy or not, and where.

    Parameters
    ----------
    state : State
        ``unclear``: nothing is wrong for sure, but an effect could still gain enough to be named.
    found : Adequacy
        What tolerances alone leave over.
    could_gain : float
        Log evidence that an effect could gain at most.
    reasons : tuple of str
        Why it is a gap.
    where : tuple of str
        For people: joints, resonances, amplitude, poses, sensors.
    following : tuple of str
        What to record next to see it better.
    notes : tuple of str
        What was assumed or left out of the recordings, or looks wrong in them.
    """

    state: State
    found: Adequacy
    could_gain: float
    reasons: tuple[str, ...]
    where: tuple[str, ...]
    following: tuple[str, ...]
    notes: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama gap --quick --json`` prints."""
        return {
            'state': self.state.value,
            'over_noise': sqrt(self.found.fitted),
            'over_noise_heldout': _root(self.found.heldout),
            'log_evidence_to_gain': self.could_gain,
            'reasons': list(self.reasons),
            'where': list(self.where),
            'next': list(self.following),
            'notes': list(self.notes),
        }


def _root(misfit: float) -> float | None:
    return sqrt(misfit) if isfinite(misfit) else None


def quick_look(
    model: FlexibleJointModel,
    campaign: Campaign,
    settings: SearchSettings | None = None,
    seed: int = 0,
    progress: Progress = lambda _: None,
) -> QuickLook:
    """Look at the beginning of a few recordings of a campaign.

    Parameters and raises as :func:`model_gap.find_gap.find_gap`.
    """
    settings = settings or SearchSettings()
    few = of_few(split(campaign, np.random.default_rng(seed)))
    faults = weigh(rest_of(model, few), settings.tolerances)
    open_ = replace(settings, tolerances=left_open(settings.tolerances, faults))
    standing, right = as_it_stands(model, faults), put_right(few, faults)
    with threadpool_limits(limits=1, user_api='blas'):  # small matrices: threads only wait
        compared, travelled = without_travelled(standing, right, settings.band)
        if all(record.heldout for record in compared.records):
            compared = split(compared, np.random.default_rng(seed))
        search = Search.begin(standing, compared, open_)
        progress(0.3)
        search = fit_tolerances(search)
        progress(0.8)
        found = look_at(search, faults, travelled)
    progress(1.0)
    return found


def of_few(campaign: Campaign) -> Campaign:
    """Return the beginning of the recordings of a few poses; which are held out stays."""
    chosen = [
        *of_first_poses([it for it in campaign.records if not it.heldout], LIMITS.fitted_poses),
        *of_first_poses([it for it in campaign.records if it.heldout], LIMITS.heldout_poses),
    ]
    records = tuple(shortened(item, LIMITS.seconds) for item in chosen)
    return replace(campaign, records=records)


def look_at(
    search: Search, faults: tuple[Fault, ...] = (), travelled: Travelled | None = None
) -> QuickLook:
    """Return what a search says once its tolerances are fitted, before any effect is tried.

    Parameters
    ----------
    search : Search
        After ``fit_tolerances``.
    faults : tuple of Fault
        What gravity shows.
    travelled : Travelled or None
        Recordings whose joints travel too far.
    """
    fitted = search.fitted
    left = adequacy(search, fitted)
    could_gain = evidence_bound(fitted) + tolerance_excess(fitted)
    reasons = (*(fault.words() for fault in faults), *objections(left))
    if reasons:
        state = State.GAP
    else:
        agrees = not objections(left, AGREEING)
        enough = agrees and could_gain < search.settings.worth_adding
        state = State.HEALTHY if enough else State.UNCLEAR
    if state is State.HEALTHY:
        return QuickLook(state, left, could_gain, (), (), (), search.notes)
    if compares_none(travelled) and objections(left):
        reasons = (travelled.words, *reasons)
        following = (travelled.next_recording,)
        return QuickLook(state, left, could_gain, reasons, (), following, search.notes)
    noisy = max(left.fitted, left.worst.misfit / 2.0) > LEAST_TO_DESCRIBE
    remains = what_remains(search, fitted.hypothesis) if noisy else ()
    where = (
        *_stretched(search),
        *_modes(search),
        *_joints(search),
        *(item.words for item in remains),
    )
    more = tuple(item.next_recording for item in remains)
    return QuickLook(state, left, could_gain, reasons, where, more, search.notes)


def _stretched(search: Search) -> tuple[str, ...]:
    """Return the tolerances that went farther than ordinary imperfection does."""
    hypothesis = search.fitted.hypothesis
    pairs = zip(hypothesis.tolerances, hypothesis.tolerance_values.tolist(), strict=True)
    far = sorted(((abs(value), item.name) for item, value in pairs), reverse=True)
    return tuple(
        f'{name} would have to be {size:.1f} times its tolerance from nominal'
        for size, name in far[:3]
        if size > STRETCHED
    )


def _modes(search: Search) -> tuple[str, ...]:
    """Return the modes of one recording that the model has elsewhere, or not at all."""
    band = min(search.settings.band.high_hz, search.campaign.motion_band_hz)
    one = mode_pairs(search, search.fitted, band, poses=1, levels=1)
    far = sorted(one, key=lambda pair: -abs(pair.deviations(pair.before)))
    moved = tuple(
        f'the mode of {FREQUENCY.text(pair.before.frequency_hz, pair.before.frequency_sigma_hz)}'
        f' is measured at {_measured(pair)}'
        for pair in far
        if pair.before and abs(pair.deviations(pair.before)) > LIMITS.telling_sigma
    )
    new = (
        f'no mode of the model has the shape of that measured at {_measured(pair)}'
        for pair in one
        if pair.before is None
    )
    return (*moved[:3], *new)


def _measured(pair: ModePair) -> str:
    mode = pair.mode
    return f'{FREQUENCY.text(mode.frequency_hz, mode.frequency_std_hz)} in {pair.record}'


def _joints(search: Search) -> tuple[str, ...]:
    """Return the joints in which a torque would account for much of what the model leaves."""
    found = joint_shares(search.nominal, search.data.fitting)
    parts = sorted(found.explained, key=lambda place: -found.explained[place])[:2]
    return tuple(
        f'a torque in {in_words(place)} would account for {share:.0%} of the whole difference'
        for place in parts
        if (share := found.explained[place] / found.total) > LIMITS.telling_share
    )
