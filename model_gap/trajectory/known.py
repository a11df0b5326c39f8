"""What a model already contains of encoder campaigns: effects found earlier."""

from collections.abc import Sequence
import dataclasses

import numpy as np

from model_gap.trajectory.catalogue import encoder_offsets, torque_terms, twist_terms
from model_gap.trajectory.motion import Motion
from model_gap.trajectory.rigid import rigid_of, rigid_torque
from model_gap.trajectory.term import Array, Term, TORQUE, Track, TWIST
from structural_model import FlexibleJointModel
from structural_model.description import KnownEffect


def known_terms(model: FlexibleJointModel, motions: Sequence[Motion]) -> list[tuple[Term, Array]]:
    """Return the laws that the model lists among its effects, with their weights."""
    rigid, encoders = rigid_of(model), motions[0].encoders
    catalogue = [
        *torque_terms(rigid, motions),
        *twist_terms(model, encoders, {}),
        *encoder_offsets(rigid, encoders),
    ]
    by_key = {term.key: term for term in catalogue}
    return [
        _with_numbers(by_key[effect.type, effect.location], effect)
        for effect in model.spec.effects
        if effect.kept_in == 'effects' and (effect.type, effect.location) in by_key
    ]


def known_keys(model: FlexibleJointModel) -> frozenset[tuple[str, str]]:
    """Return type and place of every law that the model lists."""
    return frozenset((item.type, item.location) for item in model.spec.effects)


def _with_numbers(term: Term, effect: KnownEffect) -> tuple[Term, Array]:
    numbers = {item.name: item.value for item in effect.parameters}
    if term.shape_name:
        term = dataclasses.replace(term, shape=numbers[term.shape_name])
    return term, term.weights_of(numbers)


def track_of(
    model: FlexibleJointModel, motion: Motion, known: Sequence[tuple[Term, Array]]
) -> Track:
    """Return a recording as laws see it, with what the model predicts of it."""
    rigid = rigid_torque(rigid_of(model), motion)
    compliance = np.array([1.0 / item.drive.spring.stiffness for item in model.spec.joints])
    joints = list(motion.encoders)
    twist = rigid.load[:, joints] * compliance[joints]
    known_of = {TORQUE: rigid.total, TWIST: twist}
    track = Track(motion, rigid, rigid.load, known_of, compliance, np.zeros_like(rigid.load))
    predicted = dict(track.known)
    for term, weights in known:
        predicted[term.quantity] = predicted[term.quantity] + term.columns(track) @ weights
    return dataclasses.replace(track, known=predicted)
