"""From a search to a quantity: laws with numbers of all recordings, errors before and after."""

from collections.abc import Sequence
import dataclasses
import math

import numpy as np

from model_gap.trajectory.confirm import (
    confirmed,
    errors,
    heldout_square,
    size_of,
    square_before,
)
from model_gap.trajectory.encoder_gap import Law, Quantity
from model_gap.trajectory.fit import Fit, fit_terms
from model_gap.trajectory.gear_told import gear_told, GearTold
from model_gap.trajectory.predict import predicted
from model_gap.trajectory.problem import Layout, Problem, problem_of, Sums, sums_of, total
from model_gap.trajectory.rival import Rival, rival_of
from model_gap.trajectory.search import Found, honest_covariance, recentred
from model_gap.trajectory.term import Array, TORQUE, Track, TWIST
from model_gap.trajectory.twist_terms import JointStiffness
from structural_model.description import KnownEffect

Summed = tuple[Problem, Sums]


def quantity_of(
    name: str,
    rows: Sequence[str],
    searched: Found,
    tracks: Sequence[Track],
    count: int,
) -> Quantity:
    """Return what was found of torques or twists, confirmed by the held-out recordings.

    Parameters
    ----------
    name : str
        ``torque`` or ``twist``.
    rows : sequence of str
        Joints.
    searched : Found
        In the fitted recordings.
    tracks : sequence of Track
        All recordings, fitted ones first.
    count : int
        How many were fitted.
    """
    sought, unconfirmed = confirmed(searched, tracks[count:])
    found = recentred(sought, tracks[:count])
    whole = _summed(tracks, found)
    layout, all_fit, spread = _fitted(whole, found)
    after = {track.motion.name: np.sqrt(errors(track, found, found.fit)) for track in tracks}
    other = _fitted(_summed(tracks[count:], found), found)
    laws = tuple(
        _law(item, found, ((layout, all_fit, spread), other), tracks[count:])
        for item in found.accepted
    )
    return Quantity(
        name,
        tuple(rows),
        found,
        laws,
        layout,
        all_fit,
        spread,
        unconfirmed,
        size_of(tracks[count:], name),
        _rivals(name, rows, found, tracks, count),
        _before(tracks, name),
        after,
        {track.motion.name: _noise(track, name) for track in tracks},
        _gears(rows, found, whole, tracks) if name == TWIST else (),
    )


def _noise(track: Track, name: str) -> Array:
    return track.motion.torque_noise_nm if name == TORQUE else track.motion.twist_noise_rad


def _gears(
    rows: Sequence[str], found: Found, whole: Summed, tracks: Sequence[Track]
) -> tuple[GearTold, ...]:
    """Return what all recordings tell of the springs that are not among the laws."""
    terms = found.problem.layout.terms
    springs = [
        (item, term)
        for item, term in enumerate(terms)
        if isinstance(term, JointStiffness) and item not in found.accepted
    ]
    layout, fit, spread = _fitted(whole, found, tuple(item for item, _ in springs))
    fit = dataclasses.replace(fit, covariance=spread)
    return tuple(
        gear_told(
            term,
            rows[term.axis],
            *fit.of(layout, item),
            np.concatenate([track.load_nm[:, term.joint] for track in tracks]),
        )
        for item, term in springs
    )


def _rivals(
    name: str, rows: Sequence[str], found: Found, tracks: Sequence[Track], count: int
) -> tuple[Rival, ...]:
    """Return what data alone make of every row."""
    layout, fit = found.problem.layout, found.fit
    before = [_centred(track.left_by_model(name), name) for track in tracks]
    after = [track.left(name) - predicted(track, layout, fit) for track in tracks]
    motion = tracks[0].motion
    joints = range(len(rows)) if name == TORQUE else motion.encoders
    return tuple(
        rival_of(
            tracks,
            count,
            joint,
            [item[:, row] for item in before],
            [item[:, row] for item in after],
        )
        for row, joint in enumerate(joints)
    )


def _centred(left: Array, name: str) -> Array:
    """Return what is left over; of twists without what the encoders count from."""
    return left - left.mean(axis=0) if name == TWIST else left


def _before(tracks: Sequence[Track], name: str) -> dict[str, Array]:
    return {track.motion.name: np.sqrt(square_before(track, name)) for track in tracks}


def _summed(tracks: Sequence[Track], found: Found) -> Summed:
    """Return what the laws of a search do in other recordings, and its sums."""
    problem = problem_of(tracks, found.problem.layout.terms)
    return problem, total(sums_of(problem, found.memory))


def _fitted(
    summed: Summed, found: Found, beside: tuple[int, ...] = ()
) -> tuple[Layout, Fit, Array]:
    """Return the laws that were found, and some beside them, fitted to other recordings."""
    problem, sums = summed
    fit = fit_terms(sums, problem.layout, (*found.fit.chosen, *beside))
    return problem.layout, fit, honest_covariance(problem, fit)


def _widened(whole: KnownEffect, heldout: KnownEffect, fitted: KnownEffect) -> KnownEffect:
    """Return an effect with σ no smaller than half of what the two parts differ by.

    That is the standard error of the mean of two: what a law gets wrong in one whole motion no
    block of it shows.
    """
    parameters = tuple(
        dataclasses.replace(item, sigma=max(item.sigma, 0.5 * abs(one.value - two.value)))
        for item, one, two in zip(
            whole.parameters, fitted.parameters, heldout.parameters, strict=True
        )
    )
    return dataclasses.replace(whole, parameters=parameters)


def _law(
    item: int,
    found: Found,
    others: Sequence[tuple[Layout, Fit, Array]],
    heldout: Sequence[Track],
) -> Law:
    own = found.problem.layout
    term = own.terms[item]
    effects = [
        term.known(*dataclasses.replace(fit, covariance=spread).of(layout, item))
        for layout, fit, spread in (*others, (own, found.fit, found.covariance))
    ]
    rest = tuple(other for other in found.fit.chosen if other != item)
    fewer = fit_terms(found.sums, own, rest)
    return Law(
        term=term,
        effect=_widened(*effects),
        heldout=effects[1],
        fitted=effects[2],
        gain=found.gains[item],
        without=math.sqrt(heldout_square(found, fewer, heldout)),
        all_in=math.sqrt(heldout_square(found, found.fit, heldout)),
        rivals=tuple(own.terms[other].label for other in found.rivals[item]),
    )
