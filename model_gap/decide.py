"""From evidence to a verdict: named, ambiguous, unexplained or none.

Evidence alone is not enough: what is left over must be noise on records that took no part, the
tolerances must stay ordinary, and no other explanation may be nearly as good.
"""

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from model_gap.discriminate import experiments_between, separation_now
from model_gap.hypothesis import Hypothesis
from model_gap.joint_vector import in_words
from model_gap.reach import joint_shares
from model_gap.search import Candidate, Search, Step

# On 15 healthy campaigns (gap_matrix.py --quick --only none --first-seed 200) no effect promised
# more than 2.4, fitted records left at most 1.07 and held-out ones, for lack of poses, at most
# 1.65: no false alarm, which bounds their rate at 18 % (95 %).  See docs/model_gap.md.
EVIDENCE_TO_ADD = 12.0
EVIDENCE_BETWEEN = 8.0
# χ: gap over noise floor of 1.5, squared.
EXPLAINED_MISFIT = 2.25
NO_GAP_MISFIT = 1.5
MOST_TOLERANCE = 4.5
LEAST_FIT_POSES = 2
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


def worth_adding(step: Step) -> bool:
    """Return whether the best candidate of a step earns its place."""
    if not step.candidates:
        return False
    best = step.candidates[0]
    held = best.heldout_misfit
    agrees = not np.isfinite(held) or held < 1.03 * step.heldout_before
    return best.gain >= EVIDENCE_TO_ADD and agrees


def decide(search: Search) -> Decision:
    """Judge the steps of a search."""
    accepted = tuple(step.candidates[0] for step in search.steps if worth_adding(step))
    limits = too_little(search)
    if not accepted:
        return _without_effects(search, limits)
    final = accepted[-1]
    misfit = _worst(final.fit.misfit, final.heldout_misfit)
    stretched = float(np.abs(final.fit.hypothesis.tolerance_values).max(initial=0.0))
    pairs = _rivals(search, accepted)
    rivals = tuple(other for _, other in pairs)
    if misfit > EXPLAINED_MISFIT or stretched > MOST_TOLERANCE:
        reason = (
            f'the best explanation leaves {np.sqrt(misfit):.1f} times the noise'
            if misfit > EXPLAINED_MISFIT
            else f'the best explanation needs a tolerance {stretched:.1f} times its usual size'
        )
        hint = _hint(search, final.fit.hypothesis)
        return Decision(Verdict.UNEXPLAINED, (), accepted + rivals, (reason, *hint, *limits))
    if rivals or limits:
        return Decision(
            Verdict.AMBIGUOUS,
            accepted,
            rivals,
            (*(f'{item.effect!r} explains it nearly as well' for item in rivals), *limits),
            experiments(search, pairs) + limits,
        )
    return Decision(Verdict.NAMED, accepted)


def _without_effects(search: Search, limits: tuple[str, ...]) -> Decision:
    step = search.steps[0]
    misfit = _worst(step.before.misfit, step.heldout_before)
    quiet = step.before.misfit <= NO_GAP_MISFIT and misfit <= EXPLAINED_MISFIT
    values = step.before.hypothesis.tolerance_values
    stretched = float(np.abs(values).max(initial=0.0))
    if quiet and stretched > MOST_TOLERANCE:
        name = step.before.hypothesis.tolerances[int(np.argmax(np.abs(values)))].name
        reason = f'{name} would have to be {stretched:.1f} times its tolerance from nominal'
        return Decision(Verdict.UNEXPLAINED, (), step.candidates[:3], (reason, *limits))
    if quiet:
        reasons = ('what differs is noise and known tolerance', *limits)
        return Decision(Verdict.NONE, reasons=reasons)
    reason = f'{np.sqrt(misfit):.1f} times the noise remains and no effect explains it'
    hint = _hint(search, step.before.hypothesis)
    return Decision(Verdict.UNEXPLAINED, (), step.candidates[:3], (reason, *hint, *limits))


def _hint(search: Search, hypothesis: Hypothesis) -> tuple[str, ...]:
    """Return in which joint an unknown torque would account for most of what is left."""
    found = joint_shares(hypothesis, search.fitting)
    if not found.explained:
        return ()
    place = max(found.explained, key=lambda name: found.explained[name])
    share = found.explained[place] / found.total
    if share < TELLING_SHARE:
        return ()
    return (
        f'a torque in {in_words(place)}, whatever its law, would account for {share:.0%} of it',
    )


def _worst(misfit: float, heldout: float) -> float:
    return max(misfit, heldout) if np.isfinite(heldout) else misfit


def _rivals(
    search: Search, accepted: tuple[Candidate, ...]
) -> tuple[tuple[Candidate, Candidate], ...]:
    found = []
    final = [effect.key for effect in accepted[-1].fit.hypothesis.effects]
    for step, best in zip(search.steps, accepted, strict=False):
        if best.effect.key not in final:
            continue  # dropped later
        for other in step.candidates[1:]:
            close = best.gain - other.gain < EVIDENCE_BETWEEN
            if close and other.effect.key != best.effect.key:
                found.append((best, other))
    return tuple(found)


def too_little(search: Search) -> tuple[str, ...]:
    """Return what the campaign lacks for a confident name."""
    lacks = []
    if len(search.fitting.poses) < LEAST_FIT_POSES:
        lacks.append('only one pose was fitted: record at least three more, far apart')
    if not search.heldout.records:
        lacks.append('no pose was held out: record at least three poses')
    if len({item.level for item in search.campaign.records}) < 2:
        lacks.append('only one amplitude level: record a second one, half or twice as large')
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
        now = separation_now(one, two, search.coarse)
        pair = f'{best.effect!r} or {other.effect!r}'
        for item in experiments_between(one, two, search.coarse, rng)[:2]:
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
