"""Effects and ordinary imperfections that change masses, springs and dampers of the arm."""

from collections.abc import Sequence
import dataclasses
import math

import numpy as np

from abb_emulator.mechanics.arm_effect import ArmEffect
from modal_core.channel import Channel
from modal_core.errors import SettingsError
from structural_model.description import (
    AbsorberSpec,
    HingeSpec,
    LinkSpec,
    MassSpec,
    ModelSpec,
    RodSpec,
    Spring,
)
from structural_model.flexible_joint_model import FlexibleJointModel

ROCKING = (3, 4)
ROD_JOINTS = (1, 2)
MASS_SIGMA, STIFFNESS_SIGMA, DAMPING_SIGMA = 0.01, 0.015, 0.08
INERTIA_SIGMA, PLACE_SIGMA_M, GAIN_SIGMA = 0.02, 0.003, 0.007


def with_effects(
    model: FlexibleJointModel, effects: Sequence[ArmEffect], channels: Sequence[Channel]
) -> FlexibleJointModel:
    """Return the arm with the effects that are masses, springs or dampers; others do nothing.

    Parameters
    ----------
    model : FlexibleJointModel
        As its file says.
    effects : sequence of ArmEffect
        What it has besides.
    channels : sequence of Channel
        Where sensors with a mass sit.

    Raises
    ------
    SettingsError
        No such joint, link or sensor.
    """
    spec = model.spec
    for number, effect in enumerate(effects):
        spec = _changed(model, spec, effect, channels, f'effect_{number}')
    return model if spec is model.spec else model.replace(spec)


def with_tolerances(
    model: FlexibleJointModel, size: float, random: np.random.Generator
) -> FlexibleJointModel:
    """Return an arm as it comes: masses 1 %, springs 1.5 %, dampers 8 %, centres of mass 3 mm.

    Parameters
    ----------
    model : FlexibleJointModel
        As its file says.
    size : float
        Multiplies these standard deviations.
    random : numpy.random.Generator
        Draws them.
    """
    if size == 0.0:
        return model
    known = {link.name for link in model.spec.links}
    moving = [name for name in model.body_links if name not in known]
    added = tuple(LinkSpec(name) for name in moving if name.startswith('link'))
    spec = dataclasses.replace(model.spec, links=(*model.spec.links, *added))
    model = model.replace(spec)
    sigma = {
        'stiffness': STIFFNESS_SIGMA,
        'damping': DAMPING_SIGMA,
        'mass_factor': MASS_SIGMA,
        'mass_kg': MASS_SIGMA,
        'inertia_factor': INERTIA_SIGMA,
    }
    values = {}
    for name, value in model.parameters().items():
        last = name.rsplit('.', 1)[-1]
        if last in sigma and math.isfinite(value):
            values[name] = value * math.exp(size * sigma[last] * random.standard_normal())
        elif '.com_shift_m.' in name:
            values[name] = value + size * PLACE_SIGMA_M * random.standard_normal()
    return model.with_parameters(values)


def check_place(effect: ArmEffect, known: Sequence[str]) -> None:
    """Refuse a place the arm does not have.

    Raises
    ------
    SettingsError
        With the places there are.
    """
    if effect.place not in known:
        raise SettingsError(
            'no such place', where=effect.type, found=effect.place, expected=', '.join(known)
        )


def _changed(
    model: FlexibleJointModel,
    spec: ModelSpec,
    effect: ArmEffect,
    channels: Sequence[Channel],
    name: str,
) -> ModelSpec:
    match effect.type:
        case 'joint_stiffness' | 'joint_damping':
            return _with_drive(model, spec, effect)
        case 'servo_compliance':
            return _with_servos(spec, effect)
        case 'base_compliance':
            springs = list(spec.base.springs)
            for number in ROCKING:
                springs[number] = _in_series(springs[number], effect)
            base = dataclasses.replace(spec.base, springs=tuple(springs))  # type: ignore[arg-type]
            return dataclasses.replace(spec, base=base)
        case 'rod_spring':
            first, second = (model.joint_names[joint] for joint in ROD_JOINTS)
            weights = ((first, 1.0), (second, math.copysign(1.0, effect.number('sign'))))
            stiffness = effect.number('stiffness')
            rod = RodSpec(name, weights, Spring(stiffness, effect.number('loss_time') * stiffness))
            return dataclasses.replace(spec, rods=(*spec.rods, rod))
        case 'payload' | 'sensor_mass':
            mass = _mass(model, effect, channels, name)
            return dataclasses.replace(spec, masses=(*spec.masses, mass))
        case 'link_flexibility' | 'tuned_mass':
            check_place(effect, model.link_names)
            return _with_spring_in_link(spec, effect, name)
    return spec


def _with_drive(model: FlexibleJointModel, spec: ModelSpec, effect: ArmEffect) -> ModelSpec:
    check_place(effect, model.joint_names)
    field = 'stiffness' if effect.type == 'joint_stiffness' else 'damping'
    joints = []
    for joint in spec.joints:
        if joint.name == effect.place:
            value = getattr(joint.drive.spring, field) * effect.number('factor')
            spring = dataclasses.replace(joint.drive.spring, **{field: value})
            joint = dataclasses.replace(
                joint, drive=dataclasses.replace(joint.drive, spring=spring)
            )
        joints.append(joint)
    return dataclasses.replace(spec, joints=tuple(joints))


def _with_servos(spec: ModelSpec, effect: ArmEffect) -> ModelSpec:
    omega = 2.0 * math.pi * effect.number('frequency')
    joints = []
    for joint in spec.joints:
        drive = joint.drive
        inertia = drive.rotor_inertia_kg_m2 * drive.gear_ratio**2
        if inertia > 0.0 and not drive.spring.rigid:
            damping = 2.0 * effect.number('damping_ratio') * inertia * omega
            drive = dataclasses.replace(drive, servo=Spring(inertia * omega**2, damping))
        joints.append(dataclasses.replace(joint, drive=drive))
    return dataclasses.replace(spec, joints=tuple(joints))


def _in_series(spring: Spring, effect: ArmEffect) -> Spring:
    compliance = effect.number('compliance')
    if spring.rigid:
        return Spring(1.0 / compliance, effect.number('loss_time') / compliance)
    stiffness = 1.0 / (1.0 / spring.stiffness + compliance)
    return Spring(stiffness, spring.damping * stiffness / spring.stiffness)


def _mass(
    model: FlexibleJointModel, effect: ArmEffect, channels: Sequence[Channel], name: str
) -> MassSpec:
    if effect.type == 'payload':
        check_place(effect, model.link_names)
        com, gyration = effect.vector('com'), effect.vector('gyration')
        return MassSpec(name, effect.place, effect.number('mass'), com, gyration)
    sensors = {channel.name.split('.')[0]: channel for channel in channels}
    check_place(effect, tuple(sensors))
    channel = sensors[effect.place]
    return MassSpec(name, channel.frame_id, effect.number('mass'), channel.position_m)


def _with_spring_in_link(spec: ModelSpec, effect: ArmEffect, name: str) -> ModelSpec:
    place, axis = effect.vector('position'), effect.vector('axis')
    if effect.type == 'link_flexibility':
        compliance = effect.number('compliance')
        spring = Spring(1.0 / compliance, effect.number('loss_time') / compliance)
        hinge = HingeSpec(name, effect.place, place, axis, spring)
        return dataclasses.replace(spec, hinges=(*spec.hinges, hinge))
    mass, omega = effect.number('mass'), 2.0 * math.pi * effect.number('frequency')
    spring = Spring(mass * omega**2, 2.0 * effect.number('damping_ratio') * mass * omega)
    absorber = AbsorberSpec(name, effect.place, place, axis, mass, spring)
    return dataclasses.replace(spec, absorbers=(*spec.absorbers, absorber))
