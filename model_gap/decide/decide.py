"""From evidence to a verdict: named, ambiguous, unexplained or none.

Evidence alone is not enough: what is left over must be noise on records that took no part, the
tolerances must stay ordinary, and no other explanation may be nearly as good.
"""

from dataclasses import dataclass, field, replace
from enum import Enum
import itertools

import numpy as np

from model_gap.campaign import flat_topped
from model_gap.cell import in_words
from model_gap.decide.adequacy import Adequacy, adequacy
from model_gap.decide.discriminate import experiments_between, separation_now
from model_gap.hypothesis import Hypothesis
from model_gap.search import Candidate, joint_shares, Search

# Set by healthy campaigns (benchmarks/gap_matrix.py --calibrate): see docs/measured/model_gap.md.
EVIDENCE_BETWEEN = 8.0
# Times χ of the held-out records without the effect.
MOST_WORSE = 1.03
# χ of all data (1.5 times the noise), and of one band at one amplitude level (twice the noise):
# far above healthy arms, below the strangers that were tried.
MOST_MISFIT = 2.25
MOST_CELL_MISFIT = 4.0
MOST_TOLERANCE = 4.5
LEAST_FIT_POSES = 2
# Relative.
NEAR_LIMIT = 1e-3
EXPERIMENT_SEED = 0
# Of what is left: a joint that could account for so much is worth a look.
TELLING_SHARE = 0.6


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
    """

    verdict: Verdict
    accepted: tuple[Candidate, ...] = ()
    rivals: tuple[Candidate, ...] = ()
    reasons: tuple[str, ...] = field(default=())
    experiments: tuple[str, ...] = field(default=())


def believed(search: Search) -> tuple[Candidate, ...]:
    """Return the best candidates of the steps up to the last that held-out records confirm."""
    last, least = 0, np.inf
    for number, step in enumerate(search.rounds, start=1):
        if not search.earns_place(step):
            break
        held, least = step.candidates[0].heldout_misfit, min(least, step.heldout_before)
        if not np.isfinite(held) or held < MOST_WORSE * least:
            last = number
    return tuple(step.candidates[0] for step in search.rounds[:last])


def decide(search: Search) -> Decision:
    """Judge the steps of a search."""
    accepted = believed(search)
    limits = too_little(search)
    if not accepted:
        return _without_effects(search, limits)
    final = accepted[-1].fit
    pairs = rivals_of(search, accepted)
    rivals = tuple(other for _, other in pairs)
    why = objections(adequacy(search, final)) + at_limits(final.hypothesis)
    if why:
        hint = _hint(search, final.hypothesis)
        return Decision(Verdict.UNEXPLAINED, (), accepted + rivals, (*why, *hint, *limits))
    shared = one_law(final.hypothesis)
    if rivals or limits or shared:
        close = [f'{item.effect!r} explains it nearly as well' for item in rivals]
        return Decision(
            Verdict.AMBIGUOUS,
            accepted,
            rivals,
            (*close, *shared, *limits),
            experiments(search, pairs) + limits,
        )
    small = not objections(adequacy(search, search.rounds[0].before))
    reasons = ('it is small: known tolerance alone would hide it within the noise',)
    return Decision(Verdict.NAMED, accepted, reasons=reasons if small else ())


def objections(found: Adequacy) -> tuple[str, ...]:
    """Return why a hypothesis cannot be the whole truth; nothing when it can."""
    why = []
    for name, misfit, worst in (
        ('fitted', found.fitted, found.worst),
        ('held-out', found.heldout, found.worst_heldout),
    ):
        if misfit > MOST_MISFIT:
            why.append(f'{np.sqrt(misfit):.1f} times the noise remains in {name} recordings')
        elif worst.misfit > MOST_CELL_MISFIT:
            why.append(
                f'{np.sqrt(worst.misfit):.1f} times the noise remains at {worst.place} in {name} '
                'recordings'
            )
    if found.stretched > MOST_TOLERANCE:
        why.append(
            f'{found.stretched_name} would have to be {found.stretched:.1f} times its tolerance '
            'from nominal'
        )
    return tuple(why)


def at_limits(hypothesis: Hypothesis) -> tuple[str, ...]:
    """Return which effects are as large as is plausible at all: something else made them so."""
    found = []
    for effect, values in zip(hypothesis.effects, hypothesis.values(), strict=True):
        for item, value in zip(effect.parameters(hypothesis.scene)[:1], values, strict=False):
            low, high = (
                item.low + NEAR_LIMIT * abs(item.low),
                item.high - NEAR_LIMIT * abs(item.high),
            )
            if not low < value < high:
                unit = '' if item.unit == '1' else f' {item.unit}'
                found.append(
                    f'{item.name} of {effect!r} would have to be at the end of what is plausible, '
                    f'{value:.3g}{unit}, or beyond'
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
    step = search.rounds[0]
    why = objections(adequacy(search, step.before))
    if not why:
        return Decision(Verdict.NONE, reasons=limits)
    hint = _hint(search, step.before.hypothesis)
    reasons = (*why, 'no effect explains it', *hint, *limits)
    return Decision(Verdict.UNEXPLAINED, (), step.candidates[:3], reasons)


def _hint(search: Search, hypothesis: Hypothesis) -> tuple[str, ...]:
    """Return in which joint an unknown torque would account for most of what is left."""
    found = joint_shares(hypothesis, search.data.fitting)
    if not found.explained:
        return ()
    place = max(found.explained, key=lambda name: found.explained[name])
    share = found.explained[place] / found.total
    if share < TELLING_SHARE:
        return ()
    return (
        f'a torque in {in_words(place)}, whatever its law, would account for {share:.0%} of it',
    )


def rivals_of(
    search: Search, accepted: tuple[Candidate, ...]
) -> tuple[tuple[Candidate, Candidate], ...]:
    """Return what each accepted effect that was kept cannot be told from."""
    final = accepted[-1].fit
    keys = [effect.key for effect in final.hypothesis.effects]
    found = []
    for step, best in zip(search.rounds, accepted, strict=False):
        for other in step.candidates[1:]:
            close = best.gain - other.gain < EVIDENCE_BETWEEN
            # What was dropped later needs no rival; what was added later is none.
            if not close or best.effect.key not in keys or other.effect.key in keys:
                continue
            if best is accepted[-1]:
                found.append((best, other))
                continue
            beside = search.instead(final, best.effect, other)
            if beside and final.log_evidence - beside.fit.log_evidence < EVIDENCE_BETWEEN:
                found.append((replace(best, fit=final), beside))
    return tuple(found)


def too_little(search: Search) -> tuple[str, ...]:
    """Return what the campaign lacks for a confident name."""
    lacks = []
    if len(search.data.fitting.poses) < LEAST_FIT_POSES:
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


def experiments(
    search: Search, rivals: tuple[tuple[Candidate, Candidate], ...]
) -> tuple[str, ...]:
    """Return what would tell the rivals apart: computed first, then what is known of the pair.

    Parameters
    ----------
    search : Search
        Its records are what a next one is compared with.
    rivals : tuple of (Candidate, Candidate)
        Accepted one and its rival.
    """
    found = []
    for best, other in rivals:
        one, two = best.fit.hypothesis, other.fit.hypothesis
        rng = np.random.default_rng(EXPERIMENT_SEED)
        now = separation_now(one, two, search.data.coarse)
        pair = f'{best.effect!r} or {other.effect!r}'
        for item in experiments_between(one, two, search.data.coarse, rng)[:2]:
            if item.separation > 1.2 * now:
                found.append(
                    f'{pair}: {item.words}; they would differ by {item.separation:.1f} times the '
                    f'noise, {now:.1f} in this campaign'
                )
        text = best.effect.confused_with.get(other.effect.type) or (
            other.effect.confused_with.get(best.effect.type)
        )
        if text:
            found.append(f'{pair}: {text}')
    return tuple(dict.fromkeys(found))
