"""From evidence to a verdict: named, ambiguous, unexplained or none.

Evidence alone is not enough: what is left over must be noise on records that took no part, the
tolerances must stay ordinary, and no other explanation may be nearly as good.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
import itertools
import logging

import numpy as np

from model_gap.campaign import flat_topped
from model_gap.cell import in_words
from model_gap.decide.adequacy import Adequacy, adequacy
from model_gap.decide.discriminate import experiments_between, separation_now
from model_gap.decide.locate import gap_fraction
from model_gap.decide.open_places import is_place, place_reasons
from model_gap.decide.what_remains import what_remains
from model_gap.effects import Effect, EffectParameter
from model_gap.fit import FIT, Fit
from model_gap.hypothesis import Hypothesis
from model_gap.search import Candidate, EVIDENCE_BETWEEN, joint_shares, RivalPair, Round, Search

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class DecisionLimits:
    """What an explanation must keep to be believed.

    Measured on healthy arms and on strangers to the catalogue: docs/measured/model_gap.md.

    Parameters
    ----------
    misfit, worst_misfit : float
        χ of all data (1.3 times the noise), and of one band at one amplitude level (twice the
        noise): far above healthy arms, below the strangers that were tried.  Right names left
        up to 1.3 times the noise, wrong ones from 1.4: a drifting clock, a Stribeck curve.
    chance, worst_chance : float
        Beyond these by chance, in standard deviations of a mean of squares, 1/√n of n data.
    heldout_chance : float
        Least chance of held-out records, were there tolerances and noise alone.
    tolerance : float
        Largest tolerance, in prior standard deviations.
    least_fit_poses : int
        For a confident name.
    near_end : float
        Relative distance of a number from the end of its range that counts as at the end.
    telling_share : float
        Of what is left: a joint that could account for so much is worth a look.
    telling_separation : float
        An experiment is proposed when it separates rivals so many times better than the campaign.
    """

    misfit: float = 1.7
    worst_misfit: float = 4.0
    chance: float = 0.0
    worst_chance: float = 0.0
    heldout_chance: float = 0.0
    tolerance: float = 4.5
    least_fit_poses: int = 2
    near_end: float = 1e-3
    telling_share: float = 0.6
    telling_separation: float = 1.2


LIMITS = DecisionLimits()
# What a model must keep for `none`, beside what it is off itself: one healthy arm in 1000 does not
# in all data or in those of one of a dozen bands and levels. Of nine healthy arms of a multibody
# engine χ was 0.99 ± 0.012 (1/√n: 0.011), its largest 1.01, and 1.15 in a band.
AGREEING = replace(
    LIMITS, misfit=1.02, worst_misfit=1.1, chance=3.1, worst_chance=4.0, heldout_chance=1e-3
)
EXPERIMENT_SEED = 0
# No one has seen more arms.
MOST_SAID = 1_000_000
NOT_AT_ALL = ('no effect explains it',)


class Verdict(Enum):
    """What the search concludes."""

    NAMED = 'named'
    AMBIGUOUS = 'ambiguous'
    UNEXPLAINED = 'unexplained'
    NONE = 'none'


@dataclass(frozen=True)
class Decision:
    """A verdict and its reasons.

    Parameters
    ----------
    verdict : Verdict
        The conclusion.
    accepted : tuple of Candidate
        The effects, in the order they were found.
    rivals : tuple of Candidate
        Explanations that cannot be told from the accepted ones.
    reasons : tuple of str
        For people.
    experiments : tuple of str
        What to record next.
    only_places : bool
        What the effects are is certain; of some it is not where they are.
    """

    verdict: Verdict
    accepted: tuple[Candidate, ...] = ()
    rivals: tuple[Candidate, ...] = ()
    reasons: tuple[str, ...] = field(default=())
    experiments: tuple[str, ...] = field(default=())
    only_places: bool = False


def decide(search: Search) -> Decision:
    """Return the verdict on what a search found; nothing is fitted any more."""
    found = _decided(search)
    effects = [item.effect for item in found.accepted]
    log.debug('%s: %s; %s', found.verdict.value, effects, '; '.join(found.reasons) or 'confirmed')
    return found


def _decided(search: Search) -> Decision:
    accepted, limits = search.accepted, too_little(search)
    if not accepted:
        return _without_effects(search, limits)
    final = accepted[-1].fit
    rivals = tuple(pair.rival for pair in search.rivals)
    why = objections(adequacy(search, final)) + at_limits(final.hypothesis)
    if why:
        names = ', '.join(repr(effect) for effect in final.hypothesis.effects)
        rejected = f'{names} is rejected, for it is not the whole truth: {_left(search, final)}'
        return _unexplained(search, final.hypothesis, (*why, rejected), accepted + rivals, limits)
    shared = (*one_law(final.hypothesis), *at_other_ends(final.hypothesis))
    if rivals or limits or shared:
        kinds = [pair.rival for pair in search.rivals if not is_place(pair)]
        close = tuple(f'{item.effect!r} explains it nearly as well' for item in kinds)
        return Decision(
            Verdict.AMBIGUOUS,
            accepted,
            rivals,
            (*place_reasons(search.rivals), *close, *shared, *limits),
            experiments(search, search.rivals) + limits,
            only_places=not (kinds or shared or limits),
        )
    small = not objections(adequacy(search, search.rounds[0].before), AGREEING)
    reasons = ('it is small: known tolerance alone would hide it within the noise',)
    return Decision(Verdict.NAMED, accepted, reasons=reasons if small else ())


def _left(search: Search, final: Fit) -> str:
    """Return in words how much effects take away that are not believed."""
    fits = final, search.rounds[0].before
    left, without = (gap_fraction(search.data.fitting, item.hypothesis) for item in fits)
    return f'{left:.1%} of the response remains in fitted recordings, {without:.1%} without it'


def objections(found: Adequacy, limits: DecisionLimits = LIMITS) -> tuple[str, ...]:
    """Return why a hypothesis cannot be the whole truth; nothing when it can."""
    why = []
    for name, misfit, count, worst in (
        ('fitted', found.fitted, found.count, found.worst),
        ('held-out', found.heldout, found.count_heldout, found.worst_heldout),
    ):
        if misfit > limits.misfit + limits.chance / np.sqrt(count):
            why.append(f'{np.sqrt(misfit):.3g} times the noise remains in {name} recordings')
        elif worst.misfit > limits.worst_misfit + limits.worst_chance / np.sqrt(worst.count):
            why.append(
                f'{np.sqrt(worst.misfit):.3g} times the noise remains at {worst.place} in {name} '
                'recordings'
            )
    if found.chance < limits.heldout_chance:
        arms = int(min(1.0 / max(found.chance, 1e-300), MOST_SAID))
        why.append(
            'held-out recordings differ from what was fitted by more than tolerances and noise '
            f'allow: less than one healthy arm in {arms} does so much'
        )
    if found.stretched > limits.tolerance:
        why.append(
            f'{found.stretched_name} would have to be {found.stretched:.1f} times its tolerance '
            'from nominal'
        )
    return tuple(why)


def untold(search: Search) -> bool:
    """Return whether held-out poses show a gap that the fitted ones hardly do.

    Nothing is confirmed then, and the fitted poses leave no more than a right name may.
    """
    if search.accepted or not search.data.heldout.records:
        return False
    if not objections(adequacy(search, search.rounds[0].before), AGREEING):
        return False
    return not objections(adequacy(search, search.fitted).of_fitted)


def at_limits(hypothesis: Hypothesis) -> tuple[str, ...]:
    """Return which effects are as large as is plausible at all: something else made them so."""
    found = []
    for effect, values in zip(hypothesis.effects, hypothesis.values(), strict=True):
        for item, value, size in _numbers(effect, values, hypothesis):
            if not size:
                continue
            low, high = (
                item.low + LIMITS.near_end * abs(item.low),
                item.high - LIMITS.near_end * abs(item.high),
            )
            if not low < value < high:
                found.append(
                    f'{item.name} of {effect!r} would have to be at the end of what is plausible, '
                    f'{item.said(value)}, or beyond'
                )
    return tuple(found)


def one_law(hypothesis: Hypothesis) -> tuple[str, ...]:
    """Return which effects may together be one law that is not in the catalogue.

    Play in a joint that is also far stiffer is what a stop does as well.
    """
    found = []
    for one, two in itertools.combinations(hypothesis.effects, 2):
        laws = one.amplitude_dependent or two.amplitude_dependent
        if laws and one.location is not None and one.location == two.location:
            found.append(
                f'{one!r} and {two.type} may be one law that is not in the catalogue: record a '
                'third amplitude level'
            )
    return tuple(found)


def _without_effects(search: Search, limits: tuple[str, ...]) -> Decision:
    first = search.rounds[0]
    refuted = half_explained(first, search.settings.worth_adding)
    why = objections(adequacy(search, first.before), AGREEING)
    if not why:
        return Decision(Verdict.NONE, reasons=(*refuted, *limits), experiments=limits)
    why = (*why, *(refuted or NOT_AT_ALL))
    return _unexplained(search, first.before.hypothesis, why, first.candidates[:3], limits)


def half_explained(first: Round, worth_adding: float) -> tuple[str, ...]:
    """Return which effect explains the poses that were fitted, but not those held out.

    It may be the right one from a wrong place: too few poses, or a number at the end of its range.
    """
    if not first.earns_place(worth_adding):
        return ()
    best = first.candidates[0]
    fitted, without = np.sqrt((best.fit.misfit, first.before.misfit))
    heldout, before = np.sqrt((best.heldout_misfit, first.heldout_before))
    much = 'explains' if best.fit.misfit < LIMITS.misfit else 'explains much of'
    found = (
        f'{best.effect!r} {much} the fitted poses ({fitted:.3g} times the noise remains, '
        f'{without:.3g} without it) but not the held-out ones ({heldout:.3g}, {before:.3g} '
        'without it), and is not named: more poses, far apart, would tell',
    )
    return (*found, *at_ends(best.fit.hypothesis))


def at_other_ends(hypothesis: Hypothesis) -> tuple[str, ...]:
    """Return which names may stand for others: a number that is no size is at an end of its range.

    There a law is often one that the catalogue has without that number: what swings faster than
    all else is a payload.  The size is right even so, and the name may be.
    """
    found = []
    for effect, values in zip(hypothesis.effects, hypothesis.values(), strict=True):
        for item, value, size in _numbers(effect, values, hypothesis):
            if not size and _at_end(item, value):
                found.append(f'{_end_words(effect, item, value)}: it may stand for another law')
    return tuple(found)


def at_ends(hypothesis: Hypothesis) -> tuple[str, ...]:
    """Return which numbers of the last effect lie at the end of their range."""
    effect, values = hypothesis.effects[-1], hypothesis.values()[-1]
    return tuple(
        _end_words(effect, item, value)
        for item, value, _ in _numbers(effect, values, hypothesis)
        if _at_end(item, value)
    )


def _numbers(
    effect: Effect, values: Sequence[float], hypothesis: Hypothesis
) -> list[tuple[EffectParameter, float, bool]]:
    """Return the numbers of an effect, their values, and whether each says how large it is."""
    items = effect.parameters(hypothesis.scene)
    return [
        (item, value, item.is_size_of(items[0])) for item, value in zip(items, values, strict=True)
    ]


def _at_end(item: EffectParameter, value: float) -> bool:
    # On the inner scale: of what may differ by orders of magnitude a tenth of it is no end.
    low, high = item.inner(item.low), item.inner(item.high)
    close, here = LIMITS.near_end * (high - low), item.inner(value)
    # What begins at nothing is no end.
    return here > high - close or (item.low != 0.0 and here < low + close)


def _end_words(effect: Effect, item: EffectParameter, value: float) -> str:
    name = item.name.replace('_', ' ')
    return f'{name} of {effect!r} is at the end of its range, {item.said(value)}'


def _unexplained(
    search: Search,
    hypothesis: Hypothesis,
    why: tuple[str, ...],
    rejected: tuple[Candidate, ...],
    limits: tuple[str, ...],
) -> Decision:
    """Return that nothing explains it, what is seen of it, and what to record next."""
    left = what_remains(search, hypothesis)
    reasons = (*why, *(item.words for item in left), *_hint(search, hypothesis), *limits)
    following = (*(item.next_recording for item in left), *limits)
    return Decision(Verdict.UNEXPLAINED, (), rejected, reasons, following)


def _hint(search: Search, hypothesis: Hypothesis) -> tuple[str, ...]:
    """Return in which joint an unknown torque would account for most of what is left."""
    found = joint_shares(hypothesis, search.data.fitting)
    if not found.explained:
        return ()
    place = max(found.explained, key=lambda name: found.explained[name])
    share = found.explained[place] / found.total
    if share < LIMITS.telling_share:
        return ()
    return (
        f'a torque in {in_words(place)}, whatever its law, would account for {share:.0%} of it',
    )


def too_little(search: Search) -> tuple[str, ...]:
    """Return what the campaign lacks for a confident name."""
    lacks = []
    if len(search.data.fitting.poses) < LIMITS.least_fit_poses:
        lacks.append('only one pose was fitted: record at least three more, far apart')
    if not search.data.heldout.records:
        lacks.append('no pose was held out: record at least three poses')
    if len({item.level for item in search.campaign.records}) < 2:
        lacks.append('only one amplitude level: record a second one, half or twice as large')
    names = [channel.name for channel in search.campaign.layout.channels]
    clipped = flat_topped(search.campaign.records, names)
    if clipped:
        lacks.append(
            f'cut off at the end of its range: {", ".join(clipped)}: record with a larger range, '
            'or less motion'
        )
    return tuple(lacks)


def experiments(search: Search, rivals: Sequence[RivalPair]) -> tuple[str, ...]:
    """Return what would tell the rivals apart: computed first, then what is known of the names.

    Parameters
    ----------
    search : Search
        Its records are what a next one is compared with.
    rivals : sequence of RivalPair
        Accepted ones and their rivals.
    """
    found = []
    for pair in rivals:
        best, other = pair.accepted, pair.rival
        one, two = best.fit.hypothesis, other.fit.hypothesis
        rng = np.random.default_rng(EXPERIMENT_SEED)
        now = separation_now(one, two, search.data.coarse)
        names = f'{best.effect!r} or {other.effect!r}'
        possible = experiments_between(one, two, search.data.coarse, rng)
        told = least_telling(len(search.data.fitting.records))
        least = max(LIMITS.telling_separation * now, told)
        telling = [it for it in possible if it.separation > least][:2]
        for item in telling:
            found.append(
                f'{names}: {item.words}; they would differ by {item.separation:.1f} times the '
                f'noise, {now:.1f} in this campaign'
            )
        text = best.effect.confused_with.get(other.effect.type) or (
            other.effect.confused_with.get(best.effect.type)
        )
        if text:
            found.append(f'{names}: {text}')
        elif not telling:
            most = max([now, *(item.separation for item in possible)])
            found.append(
                f'{names}: no other pose, level or known mass would tell them apart; the two '
                f'models differ by {most:.1f} times the noise at most, so that for what the arm '
                'does it matters little which it is: look at the robot'
            )
    return tuple(dict.fromkeys(found))


def least_telling(records: int) -> float:
    """Return how far apart two explanations must be in a recording for it to tell them apart.

    Times the noise: that beside so many records they differ by what the evidence asks for.
    """
    return float(np.sqrt((records + 1) * np.expm1(EVIDENCE_BETWEEN / FIT.effective_data)))
