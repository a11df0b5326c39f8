"""From a model and a campaign of encoders and torques to the laws that the model lacks."""

from collections.abc import Mapping, Sequence
import dataclasses
import math

import numpy as np
from threadpoolctl import threadpool_limits

from modal_core.work.progress import Progress
from model_gap.cell import Tolerances
from model_gap.trajectory.campaign import EncoderCampaign
from model_gap.trajectory.catalogue import (
    encoder_offsets,
    link_tolerances,
    LinkTolerance,
    load_tolerances,
    torque_terms,
    twist_terms,
)
from model_gap.trajectory.encoder_gap import EncoderGap, Quantity
from model_gap.trajectory.fit import Fit
from model_gap.trajectory.known import known_keys, known_terms, track_of
from model_gap.trajectory.motion import motion_of
from model_gap.trajectory.problem import Layout, problem_of
from model_gap.trajectory.quantity import quantity_of
from model_gap.trajectory.rigid import rigid_of
from model_gap.trajectory.search import everything, search_terms
from model_gap.trajectory.start_state import start_states
from model_gap.trajectory.term import Array, Term, TORQUE, Track, TWIST
from structural_model import FlexibleJointModel


def find_encoder_gap(
    model: FlexibleJointModel,
    campaign: EncoderCampaign,
    tolerances: Mapping[str, object] | None = None,
    progress: Progress = lambda _: None,
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
    progress: Progress,
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
    torque = quantity_of(TORQUE, model.axis_names, found, tracks, count)
    quantities = [torque]
    tracks = [loaded(track, torque.all_layout, torque.all_fit) for track in tracks]
    encoders = motions[0].encoders
    if encoders:
        sigma = load_sigma(tracks, torque)
        free = [
            *encoder_offsets(rigid, encoders),
            *load_tolerances(model, encoders, sigma),
            *start_states(tracks[:count], TWIST),
        ]
        terms = [*free, *twist_terms(model, encoders, sigma)]
        found = search_terms(
            tracks[:count], terms, len(free), there, lambda x: progress(0.7 + 0.3 * x)
        )
        names = tuple(model.axis_names[joint] for joint in encoders)
        quantities.append(quantity_of(TWIST, names, found, tracks, count))
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
    within, added = np.zeros_like(track.rigid.load), np.zeros_like(track.rigid.load)
    for item in fit.chosen:
        term = layout.terms[item]
        if term.carried:
            part = within if isinstance(term, LinkTolerance) else added
            part += term.columns(track) @ fit.of(layout, item)[0]
    return dataclasses.replace(track, load_nm=track.rigid.load + within + added, added_nm=added)


def load_sigma(tracks: Sequence[Track], torque: Quantity) -> dict[int, float]:
    """Return how roughly the size of every gear's load is known, relative.

    The load is computed from masses, payload and counterbalance: what is uncertain of them along
    the load itself makes the gear look stiffer or softer.  So does what the torques moved masses
    by within their tolerances: motions of a flexible arm, which a rigid one has to explain by
    them, move them as well, and no covariance says so.
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
        spread = math.sqrt(max(float(along @ covariance @ along), 0.0))
        found[joint] = math.hypot(spread, _moved(tracks, joint, load))
    return found


def _moved(tracks: Sequence[Track], joint: int, load: Sequence[Array]) -> float:
    """Return by what share of it masses within their tolerances changed a gear's load.

    Parameters
    ----------
    tracks : sequence of Track
        Recordings.
    joint : int
        Of the gear.
    load : sequence of (n,) array [N m]
        The load without its mean, by recording.
    """
    within = [(track.load_nm - track.rigid.load - track.added_nm)[:, joint] for track in tracks]
    along = sum(float(one @ two) for one, two in zip(load, within, strict=True))
    return abs(along) / max(sum(float(one @ one) for one in load), 1e-300)
