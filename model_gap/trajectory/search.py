"""Find which laws a quantity needs: the best by evidence, then the next, as long as it pays."""

from collections.abc import Sequence
import dataclasses
from dataclasses import dataclass
import math

import numpy as np

from modal_core.work.progress import Progress
from model_gap.search import EVIDENCE_BETWEEN, SearchSettings
from model_gap.trajectory.fit import block_covariance, Fit, fit_terms
from model_gap.trajectory.motion import RATE_HZ
from model_gap.trajectory.problem import (
    AR_ORDER,
    memory_of,
    Problem,
    problem_of,
    Sums,
    sums_of,
    total,
)
from model_gap.trajectory.term import Array, Term, Track

# Lengths of blocks: several times as long as a residual agrees with itself, and a stroke.
BLOCKS_S = (1.0, 2.5)
FEWEST = 4
MOST_TERMS = 40
RECENTRED = 4
WORTH_ADDING = SearchSettings().worth_adding


@dataclass(frozen=True)
class Found:
    """The laws of one quantity.

    Parameters
    ----------
    problem : Problem
        Columns and data of the fitted recordings.
    free : tuple of int
        Terms that are in every fit.
    accepted : tuple of int
        Terms that were found, in that order.
    fit : Fit
        Of all of these.
    covariance : array
        Of its weights: the larger of what noise and what blocks tell.
    gains : dict of int to float
        Log evidence every accepted term is worth beside the others.
    rivals : dict of int to tuple of int
        Terms that would do nearly as well instead.
    sums : Sums
        Whitened data of the fitted recordings.
    memory : array
        Of the noise they were whitened with.
    """

    problem: Problem
    free: tuple[int, ...]
    accepted: tuple[int, ...]
    fit: Fit
    covariance: Array
    gains: dict[int, float]
    rivals: dict[int, tuple[int, ...]]
    sums: Sums
    memory: Array


def search_terms(
    tracks: Sequence[Track],
    terms: Sequence[Term],
    n_free: int,
    known: frozenset[tuple[str, str]] = frozenset(),
    progress: Progress = lambda _: None,
) -> Found:
    """Find the terms that a quantity needs.

    Parameters
    ----------
    tracks : sequence of Track
        Fitted recordings.
    terms : sequence of Term
        First those that are always free, then the catalogue.
    n_free : int
        How many are always free.
    known : set of (type, location)
        Laws that the model has, whose numbers may be corrected either way.
    progress : callable
        Takes the fraction done.
    """
    problem = dataclasses.replace(problem_of(tracks, terms), known=known)
    free = tuple(range(n_free))
    accepted: list[int] = []
    memory = _unexplained_memory(problem)
    sums = total(sums_of(problem, memory))
    fit = fit_terms(sums, problem.layout, free)
    while len(accepted) < MOST_TERMS:
        gains = _gains(sums, problem, (*free, *accepted), fit)
        if not gains or max(gains.values()) < WORTH_ADDING:
            break
        accepted.append(max(gains, key=lambda item: gains[item]))
        accepted = _pruned(sums, problem, free, accepted)
        accepted = _reshaped(sums, problem, free, accepted)
        fit = fit_terms(sums, problem.layout, (*free, *accepted))
        progress(min(1.0, len(accepted) / MOST_TERMS))
    found = Found(problem, free, tuple(accepted), fit, fit.covariance, {}, {}, sums, memory)
    return judged(found)


def _unexplained_memory(problem: Problem) -> Array:
    """Return how what no law explains follows from itself.

    All laws are fitted at once for that: while one is missing the residual wanders, and noise
    that may wander as far would explain every counterbalance.
    """
    return memory_of(problem.residuals(everything(problem).full(problem.layout)))


def everything(problem: Problem) -> Fit:
    """Return all laws fitted at once, each held by its prior."""
    memory = np.zeros((problem.n_rows, AR_ORDER))
    for _ in range(2):
        chosen = range(len(problem.layout.terms))
        fit = fit_terms(total(sums_of(problem, memory)), problem.layout, chosen)
        memory = memory_of(problem.residuals(fit.full(problem.layout)))
    return fit


def _gains(sums: Sums, problem: Problem, chosen: Sequence[int], fit: Fit) -> dict[int, float]:
    """Return what every other law would add to the log evidence, one shape of each kind left."""
    terms = problem.layout.terms
    taken = {terms[item].key for item in chosen}
    found = {}
    for item, term in enumerate(terms):
        if term.key in taken:
            continue
        tried = fit_terms(sums, problem.layout, (*chosen, item))
        if term.possible(tried.of(problem.layout, item)[0], problem.known):
            found[item] = tried.evidence - fit.evidence - math.log(len(term.shapes))
    return found


def _pruned(sums: Sums, problem: Problem, free: Sequence[int], accepted: list[int]) -> list[int]:
    """Return the accepted terms without those that the later ones made superfluous."""
    while len(accepted) > 1:
        whole = fit_terms(sums, problem.layout, (*free, *accepted)).evidence
        worth = {item: whole - _without(sums, problem, free, accepted, item) for item in accepted}
        least = min(worth, key=lambda item: worth[item])
        if worth[least] >= WORTH_ADDING:
            break
        accepted = [item for item in accepted if item != least]
    return accepted


def _without(
    sums: Sums, problem: Problem, free: Sequence[int], accepted: Sequence[int], left_out: int
) -> float:
    rest = [item for item in accepted if item != left_out]
    return fit_terms(sums, problem.layout, (*free, *rest)).evidence


def _reshaped(sums: Sums, problem: Problem, free: Sequence[int], accepted: list[int]) -> list[int]:
    """Return the accepted terms each in the shape that fits best beside the others."""
    terms = problem.layout.terms
    for place, item in enumerate(accepted):
        others = [other for other in range(len(terms)) if terms[other].key == terms[item].key]
        if len(others) < 2:
            continue
        rest = accepted[:place], accepted[place + 1 :]
        best = max(
            others,
            key=lambda other: (
                fit_terms(sums, problem.layout, (*free, *rest[0], other, *rest[1])).evidence
            ),
        )
        accepted = [*rest[0], best, *rest[1]]
    return accepted


def judged(found: Found) -> Found:
    """Return the laws fitted anew, with what each is worth and what would do instead."""
    problem, free, accepted, sums = found.problem, found.free, found.accepted, found.sums
    fit = fit_terms(sums, problem.layout, (*free, *accepted))
    gains = {
        item: fit.evidence - _without(sums, problem, free, accepted, item) for item in accepted
    }
    return dataclasses.replace(
        found,
        fit=fit,
        covariance=honest_covariance(problem, fit),
        gains=gains,
        rivals=_rivals(sums, problem, free, accepted, fit),
    )


def recentred(found: Found, tracks: Sequence[Track]) -> Found:
    """Return the laws fitted about the weights that were found, until they stay.

    A place of a mass and a delay are linear to first order only.
    """
    for _ in range(RECENTRED):
        layout = found.problem.layout
        terms = list(layout.terms)
        for item in found.accepted:
            terms[item] = terms[item].recentred(found.fit.of(layout, item)[0])
        problem = problem_of(tracks, terms)
        problem = dataclasses.replace(problem, known=found.problem.known)
        sums = total(sums_of(problem, found.memory))
        fit = fit_terms(sums, problem.layout, found.fit.chosen)
        found = dataclasses.replace(found, problem=problem, sums=sums, fit=fit)
    return judged(found)


def honest_covariance(problem: Problem, fit: Fit) -> Array:
    """Return the covariance of the weights: noise's, widened to what blocks show.

    Short blocks and long ones: a law that is a little wrong leaves residuals that agree with
    themselves as long as a stroke lasts.
    """
    memory = memory_of(problem.residuals(fit.full(problem.layout)))
    longest = max(len(item) for item in problem.data)
    widest = np.diag(fit.covariance)
    for block_s in BLOCKS_S:
        parts = sums_of(problem, memory, max(FEWEST, int(longest / RATE_HZ / block_s)))
        seen = block_covariance(parts, total(parts), problem.layout, fit)
        widest = np.maximum(widest, np.diag(seen))
    wider = np.sqrt(widest / np.diag(fit.covariance))
    return np.asarray(fit.covariance * np.outer(wider, wider))


def _rivals(
    sums: Sums, problem: Problem, free: Sequence[int], accepted: Sequence[int], fit: Fit
) -> dict[int, tuple[int, ...]]:
    """Return which other laws would do nearly as well in the place of an accepted one.

    One that is worth its place beside it as well is another law, not a rival.
    """
    terms = problem.layout.terms
    found: dict[int, tuple[int, ...]] = {}
    beside = _gains(sums, problem, (*free, *accepted), fit)
    for item in accepted:
        rest = [other for other in accepted if other != item]
        close: dict[tuple[str, str], int] = {}
        for other, gain in beside.items():
            if gain >= WORTH_ADDING:
                continue
            tried = fit_terms(sums, problem.layout, (*free, *rest, other))
            if fit.evidence - tried.evidence < EVIDENCE_BETWEEN:
                close.setdefault(terms[other].key, other)
        found[item] = tuple(close.values())
    return found
