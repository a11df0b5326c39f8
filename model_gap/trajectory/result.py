"""From a model and a campaign of encoders and torques to the laws that the model lacks."""

from collections.abc import Callable, Mapping, Sequence
import dataclasses
from dataclasses import dataclass
import math

import numpy as np
from threadpoolctl import threadpool_limits

from model_gap.cell import Tolerances
from model_gap.decide import Verdict
from model_gap.trajectory.campaign import EncoderCampaign
from model_gap.trajectory.catalogue import (
    encoder_offsets,
    link_tolerances,
    torque_terms,
    twist_terms,
)
from model_gap.trajectory.confirm import (
    confirmed,
    errors,
    heldout_square,
    share_of,
    size_of,
    square_before,
)
from model_gap.trajectory.fit import Fit, fit_terms
from model_gap.trajectory.known import known_keys, known_terms, track_of
from model_gap.trajectory.motion import motion_of
from model_gap.trajectory.predict import predicted
from model_gap.trajectory.problem import Layout, problem_of, sums_of, total
from model_gap.trajectory.rigid import rigid_of
from model_gap.trajectory.rival import Rival, rival_of
from model_gap.trajectory.search import (
    everything,
    Found,
    honest_covariance,
    recentred,
    search_terms,
)
from model_gap.trajectory.start_state import start_states
from model_gap.trajectory.term import Array, Term, TORQUE, Track, TWIST
from structural_model import FlexibleJointModel
from structural_model.spec import KnownEffect


@dataclass(frozen=True)
class Law:
    """One effect that was found.

    Parameters
    ----------
    term : Term
        What and where.
    effect : KnownEffect
        With numbers from all recordings.
    fitted : KnownEffect
        With numbers from the fitted recordings alone.
    heldout : KnownEffect
        With numbers from the held-out recordings alone, with which they must agree.
    gain : float
        Log evidence it is worth beside the others.
    without, all_in : float
        Held-out gap of its quantity without it, and with all laws.
    rivals : tuple of str
        What would do nearly as well in its place.
    """

    term: Term
    effect: KnownEffect
    fitted: KnownEffect
    heldout: KnownEffect
    gain: float
    without: float
    all_in: float
    rivals: tuple[str, ...]


@dataclass(frozen=True)
class Quantity:
    """Torques or twists, before and after.

    Parameters
    ----------
    name : str
        ``torque`` or ``twist``.
    rows : tuple of str
        Joints.
    found : Found
        The search.
    laws : tuple of Law
        What was found.
    all_layout, all_fit, all_covariance
        Weights from all recordings.
    unconfirmed : tuple of Term
        Found in the fitted recordings, and no help in those held out.
    size : (n_rows,) array
        How much every row varies in the held-out recordings, as a mean square.
    rivals : tuple of Rival
        What data alone make of every row.
    before, after : dict of str to (n_rows,) array
        Rms error by recording, [N m] or [rad].
    """

    name: str
    rows: tuple[str, ...]
    found: Found
    laws: tuple[Law, ...]
    all_layout: Layout
    all_fit: Fit
    all_covariance: Array
    unconfirmed: tuple[Term, ...]
    size: Array
    rivals: tuple[Rival, ...]
    before: Mapping[str, Array]
    after: Mapping[str, Array]


@dataclass(frozen=True)
class EncoderGap:
    """What an encoder campaign tells of a model.

    Parameters
    ----------
    model : FlexibleJointModel
        As it was given.
    campaign : EncoderCampaign
        Recordings.
    tracks : tuple of Track
        Of all recordings, fitted ones first.
    quantities : tuple of Quantity
        Torques, then twists where there are encoders.
    """

    model: FlexibleJointModel
    campaign: EncoderCampaign
    tracks: tuple[Track, ...]
    quantities: tuple[Quantity, ...]

    @property
    def laws(self) -> tuple[Law, ...]:
        """All laws that were found."""
        return tuple(law for item in self.quantities for law in item.laws)

    @property
    def unexplained(self) -> list[tuple[str, str, Rival]]:
        """Quantity and axis of what data alone explain and the laws do not."""
        return [
            (item.name, row, rival)
            for item in self.quantities
            for row, rival in zip(item.rows, item.rivals, strict=True)
            if rival.beats
        ]

    @property
    def verdict(self) -> Verdict:
        """The word for all of it."""
        if any(rival.upsets for _, _, rival in self.unexplained):
            return Verdict.UNEXPLAINED
        if not self.laws:
            return Verdict.NONE
        sure = any(not law.rivals for law in self.laws)
        return Verdict.NAMED if sure else Verdict.AMBIGUOUS


def find_encoder_gap(
    model: FlexibleJointModel,
    campaign: EncoderCampaign,
    tolerances: Mapping[str, object] | None = None,
    progress: Callable[[float], None] = lambda _: None,
) -> EncoderGap:
    """Find what a model lacks of what encoders and torques show.

    Parameters
    ----------
    model : FlexibleJointModel
        With gears; springs are not needed.
    campaign : EncoderCampaign
        Recordings, fitted and held out.
    tolerances : dict or None
        How roughly masses are known; they count before the campaign's, before the model's.
    progress : callable
        Takes the fraction done.
    """
    size = Tolerances().stated(dict(model.spec.tolerances), f'{model.robot_name}: tolerances')
    size = size.stated(campaign.tolerances, 'campaign.yaml: tolerances')
    size = size.stated(tolerances or {}, 'tolerance')
    with threadpool_limits(limits=1, user_api='blas'):  # small matrices: threads only wait
        return _find(model, campaign, size, progress)


def _find(
    model: FlexibleJointModel,
    campaign: EncoderCampaign,
    size: Tolerances,
    progress: Callable[[float], None],
) -> EncoderGap:
    recordings = (*campaign.fitting, *campaign.heldout)
    motions = [motion_of(item, model, campaign.start) for item in recordings]
    known = known_terms(model, motions)
    tracks = [track_of(model, motion, known) for motion in motions]
    count, rigid = len(campaign.fitting), rigid_of(model)
    free: list[Term] = [*link_tolerances(rigid, size), *start_states(tracks[:count], TORQUE)]
    terms = [*free, *torque_terms(rigid, motions[:count])]
    tracks = _settled(tracks, terms, count)
    there = known_keys(model)
    found = search_terms(tracks[:count], terms, len(free), there, lambda x: progress(0.7 * x))
    torque = _quantity(TORQUE, model.axis_names, found, tracks, count)
    quantities = [torque]
    tracks = [loaded(track, torque.all_layout, torque.all_fit) for track in tracks]
    encoders = motions[0].encoders
    if encoders:
        free = [*encoder_offsets(rigid, encoders), *start_states(tracks[:count], TWIST)]
        terms = [*free, *twist_terms(rigid, encoders, load_sigma(tracks, torque))]
        found = search_terms(
            tracks[:count], terms, len(free), there, lambda x: progress(0.7 + 0.3 * x)
        )
        names = tuple(model.axis_names[joint] for joint in encoders)
        quantities.append(_quantity(TWIST, names, found, tracks, count))
    progress(1.0)
    return EncoderGap(model, campaign, tuple(tracks), tuple(quantities))


def _settled(tracks: Sequence[Track], terms: Sequence[Term], count: int) -> list[Track]:
    """Return recordings with the load of their gears as all laws at once have it.

    Friction in proportion to load asks for it before the laws are known.
    """
    problem = problem_of(tracks[:count], terms)
    fit = everything(problem)
    return [loaded(track, problem.layout, fit) for track in tracks]


def loaded(track: Track, layout: Layout, fit: Fit) -> Track:
    """Return a recording with the load of its gears as the laws of the torque have it."""
    load = track.rigid.load.copy()
    for item in fit.chosen:
        term = layout.terms[item]
        if term.carried:
            load += term.columns(track) @ fit.of(layout, item)[0]
    return dataclasses.replace(track, load_nm=load)


def load_sigma(tracks: Sequence[Track], torque: Quantity) -> dict[int, float]:
    """Return how roughly the size of every gear's load is known, relative.

    The load is computed from masses, payload and counterbalance: what is uncertain of them along
    the load itself makes the gear look stiffer or softer.
    """
    layout, fit = torque.all_layout, torque.all_fit
    carried = [item for item in fit.chosen if layout.terms[item].carried]
    places = np.concatenate([np.r_[layout.places[item]] for item in carried])
    rows = np.searchsorted(fit.columns, places, sorter=np.argsort(fit.columns))
    rows = np.argsort(fit.columns)[rows]
    covariance = torque.all_covariance[np.ix_(rows, rows)]
    moved = [
        np.concatenate([layout.terms[item].columns(track) for item in carried], axis=2)
        for track in tracks
    ]
    found = {}
    for joint in range(tracks[0].n_joints):
        load = [track.load_nm[:, joint] - track.load_nm[:, joint].mean() for track in tracks]
        along = sum(one @ two[:, joint] for one, two in zip(load, moved, strict=True))
        along = np.asarray(along) / max(sum(float(one @ one) for one in load), 1e-300)
        found[joint] = math.sqrt(max(float(along @ covariance @ along), 0.0))
    return found


def _quantity(
    name: str,
    rows: Sequence[str],
    searched: Found,
    tracks: Sequence[Track],
    count: int,
) -> Quantity:
    sought, unconfirmed = confirmed(searched, tracks[count:])
    found = recentred(sought, tracks[:count])
    layout, all_fit, spread = _fitted(tracks, found)
    after = {track.motion.name: np.sqrt(errors(track, found, found.fit)) for track in tracks}
    other = _fitted(tracks[count:], found)
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
    )


def _rivals(
    name: str, rows: Sequence[str], found: Found, tracks: Sequence[Track], count: int
) -> tuple[Rival, ...]:
    """Return what data alone make of every row."""
    layout, fit = found.problem.layout, found.fit
    before = [_centred(track.left(name), name) for track in tracks]
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


def gap_share(quantity: Quantity, names: Sequence[str]) -> float:
    """Return the rms error after as a share of that before, axes in units of what they show."""
    after, before = (
        np.mean([part[name] ** 2 for name in names], axis=0)
        for part in (quantity.after, quantity.before)
    )
    return math.sqrt(share_of(after, before, quantity.size))


def _fitted(tracks: Sequence[Track], found: Found) -> tuple[Layout, Fit, Array]:
    """Return the laws that were found fitted to other recordings."""
    problem = problem_of(tracks, found.problem.layout.terms)
    sums = total(sums_of(problem, found.memory))
    fit = fit_terms(sums, problem.layout, found.fit.chosen)
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
