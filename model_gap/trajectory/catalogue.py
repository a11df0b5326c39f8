"""Every law at every place it can be at, and the tolerances that are always free."""

from collections.abc import Iterator, Mapping, Sequence
import dataclasses
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import pinocchio as pin

from model_gap.cell import Tolerances
from model_gap.trajectory.friction_terms import (
    AsymmetricFriction,
    CoulombFriction,
    HoseSpring,
    LoadFriction,
    OfFriction,
    StribeckFriction,
    ViscousFriction,
)
from model_gap.trajectory.motion import Motion
from model_gap.trajectory.rigid import lower, NUMBERS, steiner
from model_gap.trajectory.term import Array, Term, Track, Weight
from model_gap.trajectory.torque_terms import GravityCompensator, Payload, RotorInertia
from model_gap.trajectory.twist_terms import (
    Backlash,
    CubicStiffness,
    EncoderDelay,
    EncoderOffset,
    Hysteresis,
    JointStiffness,
    LINK_ENCODERS,
    LoadTolerance,
    OfTwist,
    TransmissionError,
)
from structural_model import FlexibleJointModel

FRICTION: tuple[type[OfFriction], ...] = (
    CoulombFriction,
    ViscousFriction,
    AsymmetricFriction,
    LoadFriction,
    StribeckFriction,
    HoseSpring,
)
TWIST: tuple[type[OfTwist], ...] = (
    Hysteresis,
    Backlash,
    CubicStiffness,
    TransmissionError,
)
# Friction of a drive is a tenth to a third of what it moves with.
FRICTION_SHARE = 0.3
# Payload: as much as a tenth of the arm.
PAYLOAD_SHARE = 0.1
# A joint whose axis gravity does not turn about has no counterbalance [N m].
NO_GRAVITY_NM = 1.0
TURNS = np.linspace(-np.pi, np.pi, 181)


@dataclass(frozen=True)
class LinkTolerance(Term):
    """How roughly a link's inertia is known: always free within its prior, never named."""

    type: ClassVar[str] = 'tolerance'
    carried: ClassVar[bool] = True
    equation: ClassVar[str] = 'mass, centre of mass and inertia within their tolerances'
    says: ClassVar[str] = '{place} within its tolerance'
    kept_in: ClassVar[str] = 'model'

    # Inertial numbers about the joint per unit of each weight.
    directions: tuple[tuple[float, ...], ...] = ()
    names: tuple[str, ...] = ()
    sizes: Tolerances = field(default_factory=Tolerances)

    def weights(self) -> tuple[Weight, ...]:
        """Return the weights, in units of their tolerances."""
        return tuple(Weight(name, '1', 1.0) for name in self.names)

    def columns(self, track: Track) -> Array:
        """Return what they do to all drives."""
        return np.asarray(track.rigid.bodies[:, :, self.axis] @ np.array(self.directions).T)


def link_tolerances(model: FlexibleJointModel, size: Tolerances) -> list[LinkTolerance]:
    """Return one per moving link.

    Parameters
    ----------
    model : FlexibleJointModel
        Rigid.
    size : Tolerances
        How large one standard deviation is.
    """
    found = []
    for place, name in enumerate(moving_links(model)):
        body = model.assembly.model.inertias[place + 1]
        whole = np.asarray(body.toDynamicParameters())
        mass, centre = body.mass, np.asarray(body.lever)
        directions, names = [tuple(size.mass * whole)], ['mass']
        for axis in range(3):
            moved = np.zeros(3)
            moved[axis] = size.centre_of_mass_m
            moment = np.zeros(NUMBERS)
            moment[1:4] = mass * moved
            moment[4:] = 2.0 * mass * steiner(centre, moved)
            directions.append(tuple(moment))
            names.append(f'com_{"xyz"[axis]}')
        about = np.zeros(NUMBERS)
        about[4:] = size.inertia * lower(np.asarray(body.inertia))
        directions.append(tuple(about))
        names.append('inertia')
        found.append(LinkTolerance(name, place, place, directions=tuple(directions),
                                   names=tuple(names), sizes=size))  # fmt: skip
    return found


def moving_links(model: FlexibleJointModel) -> list[str]:
    """Return the link behind every joint: the one whose frame is the joint's."""
    first: dict[int, str] = {}
    for name, (joint, placement) in model.assembly.links.items():
        if joint > 0 and placement.isIdentity():
            first.setdefault(joint, name)
    return [first[place + 1] for place in range(model.n_joints)]


def torque_terms(model: FlexibleJointModel, motions: Sequence[Motion]) -> list[Term]:
    """Return every law of the torques, every shape of it one term."""
    torque = np.concatenate([item.torque_nm for item in motions])
    found: list[Term] = []
    for place, joint in enumerate(model.spec.joints):
        size = FRICTION_SHARE * float(np.ptp(torque[:, place]))
        for kind in FRICTION:
            found += shaped(kind(joint.name, place, place, size_nm=max(size, 1e-9)))
        drive = joint.drive
        if drive.rotor_inertia_kg_m2 > 0.0:
            found.append(
                RotorInertia(
                    joint.name, place, place, ratio=drive.gear_ratio,
                    nominal=drive.rotor_inertia_kg_m2,
                )
            )  # fmt: skip
    found += _compensators(model, motions)
    mass = sum(item.mass for item in model.assembly.model.inertias)
    found.append(_payload(model, PAYLOAD_SHARE * float(mass)))
    return found


def shaped(term: Term) -> list[Term]:
    """Return a term in every shape it may have."""
    return [dataclasses.replace(term, shape=shape) for shape in term.shapes]


def _payload(model: FlexibleJointModel, mass_kg: float) -> Payload:
    link = model.link_names[-1]
    _, placement = model.assembly.link(link)
    last = model.n_joints - 1
    flange = np.asarray(placement.rotation), np.asarray(placement.translation)
    return Payload(link, last, last, mass_kg=mass_kg, flange=flange)


def _compensators(
    model: FlexibleJointModel, motions: Sequence[Motion]
) -> Iterator[GravityCompensator]:
    """Return one per joint that gravity turns, neutral near where what it carries is upright."""
    pose = motions[0].joint_rad[0]
    zero = np.zeros((len(TURNS), model.n_joints))
    for place, name in enumerate(model.joint_names[:-1]):
        poses = np.tile(pose, (len(TURNS), 1))
        poses[:, place] = TURNS
        height = _height(model, poses, place)
        torque = model.torque(poses, zero, zero)[:, place]
        size = float(np.abs(torque).max())
        if size < NO_GRAVITY_NM or float(np.ptp(height)) < 1e-3:
            continue
        yield GravityCompensator(
            name, place, place, size_nm=size, upright=float(TURNS[int(np.argmax(height))])
        )


def _height(model: FlexibleJointModel, poses: Array, place: int) -> Array:
    """Return how high the next joint is above this one, (n_poses,) [m]."""
    arm = model.assembly.model
    data = arm.createData()
    up = -np.asarray(model.spec.gravity_m_s2)
    found = []
    for pose in poses:
        pin.forwardKinematics(arm, data, pose)
        way = data.oMi[place + 2].translation - data.oMi[place + 1].translation
        found.append(float(way @ up) / max(float(np.linalg.norm(up)), 1e-12))
    return np.array(found)


def twist_terms(
    model: FlexibleJointModel, encoders: Sequence[int], load_sigma: Mapping[int, float]
) -> list[Term]:
    """Return every law of the twists, every shape of it one term.

    Parameters
    ----------
    model : FlexibleJointModel
        With its springs.
    encoders : sequence of int
        Joints with an encoder behind the gear.
    load_sigma : dict of int to float
        How roughly the load of each is known, relative.
    """
    found: list[Term] = []
    if encoders:
        found.append(EncoderDelay(LINK_ENCODERS, 0, encoders[0]))
    for place, joint in enumerate(encoders):
        name = model.joint_names[joint]
        for kind in TWIST:
            found += shaped(kind(name, place, joint))
        found.append(
            JointStiffness(
                name, place, joint,
                load_sigma=load_sigma.get(joint, 0.0),
                model_stiffness=model.spec.joints[joint].drive.spring.stiffness,
            )
        )  # fmt: skip
        found.append(EncoderDelay(name, place, joint))
    return found


def load_tolerances(
    model: FlexibleJointModel, encoders: Sequence[int], load_sigma: Mapping[int, float]
) -> list[LoadTolerance]:
    """Return one per spring of the model whose load is not known exactly."""
    springs = [(place, joint, model.spec.joints[joint]) for place, joint in enumerate(encoders)]
    return [
        LoadTolerance(
            item.name, place, joint,
            load_sigma=load_sigma[joint], model_stiffness=item.drive.spring.stiffness,
        )
        for place, joint, item in springs
        if load_sigma.get(joint, 0.0) > 0.0 and not item.drive.spring.rigid
    ]  # fmt: skip


def encoder_offsets(model: FlexibleJointModel, encoders: Sequence[int]) -> list[EncoderOffset]:
    """Return where every encoder counts from."""
    return [
        EncoderOffset(model.joint_names[joint], place, joint)
        for place, joint in enumerate(encoders)
    ]
