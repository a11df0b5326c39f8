"""The model with the laws that were found, written as a robot that every room loads."""

from collections.abc import Callable, Mapping
import dataclasses
import math
from pathlib import Path

import numpy as np

from modal_core.files.atomic_file import atomic_path, write_text
from model_gap.trajectory.catalogue import LinkTolerance
from model_gap.trajectory.encoder_gap import EncoderGap, Quantity
from model_gap.trajectory.twist_terms import EncoderOffset, JointStiffness
from structural_model import FlexibleJointModel
from structural_model.description import (
    CompensatorSpec,
    KnownEffect,
    LinkSpec,
    MassSpec,
    ModelSpec,
    Spring,
)
from structural_model.robot_writer import model_text

NAME = 'model_updated.yaml'


def corrected_model(gap: EncoderGap) -> FlexibleJointModel:
    """Return the model with all laws, at the values that all recordings together give."""
    spec = gap.model.spec
    for quantity in gap.quantities:
        spec = _with_free(spec, quantity)
    for law in gap.laws:
        numbers = {item.name: item.value for item in law.effect.parameters}
        put = IN_MODEL.get(law.effect.type)
        if put is not None:
            spec = put(spec, law.effect.location, numbers)
        spec = dataclasses.replace(spec, effects=(*_others(spec, law.effect), law.effect))
    return dataclasses.replace(gap.model, spec=spec)


def write_corrected_model(gap: EncoderGap, folder: Path) -> Path:
    """Write ``model_updated.yaml`` and ``robot.urdf``; ``load_robot`` takes the first."""
    model = corrected_model(gap)
    with atomic_path(folder / 'robot.urdf') as path:
        path.write_bytes(model.robot.text)
    heading = '\n'.join(f'# + {law.term.label}' for law in gap.laws) or '# no effect was added'
    write_text(folder / NAME, f'{heading}\n{model_text(model)}')
    return folder / NAME


def _with_free(spec: ModelSpec, quantity: Quantity) -> ModelSpec:
    """Return a spec with the tolerances and the encoders' offsets as they were fitted."""
    layout = quantity.all_layout
    fit = dataclasses.replace(quantity.all_fit, covariance=quantity.all_covariance)
    for item in quantity.found.free:
        term = layout.terms[item]
        weights, covariance = fit.of(layout, item)
        if isinstance(term, LinkTolerance):
            spec = _link(spec, term, weights)
        elif isinstance(term, EncoderOffset):
            spec = _renewed(spec, term.known(weights, covariance))
    return spec


def _others(spec: ModelSpec, effect: KnownEffect) -> tuple[KnownEffect, ...]:
    """Return the effects that stay beside one: what is told of a whole gear replaces the older."""
    whole = effect.type == JointStiffness.type
    return tuple(
        item
        for item in spec.effects
        if not whole or (item.type, item.location) != (effect.type, effect.location)
    )


def _renewed(spec: ModelSpec, effect: KnownEffect) -> ModelSpec:
    """Return a spec with an effect that adds to what it said of it before."""
    key = effect.type, effect.location
    before = [item for item in spec.effects if (item.type, item.location) == key]
    others = [item for item in spec.effects if (item.type, item.location) != key]
    sums = {item.name: item.value for one in before for item in one.parameters}
    parameters = tuple(
        dataclasses.replace(item, value=item.value + sums.get(item.name, 0.0))
        for item in effect.parameters
    )
    return dataclasses.replace(
        spec, effects=(*others, dataclasses.replace(effect, parameters=parameters))
    )


def _link(spec: ModelSpec, term: LinkTolerance, weights: np.ndarray) -> ModelSpec:
    link, numbers = term.location, dict(zip(term.names, weights.tolist(), strict=True))
    size = term.sizes
    before = next((item for item in spec.links if item.name == link), LinkSpec(link))
    shift = tuple(
        old + size.centre_of_mass_m * numbers[f'com_{axis}']
        for old, axis in zip(before.com_shift_m, 'xyz', strict=True)
    )
    after = dataclasses.replace(
        before,
        mass_factor=before.mass_factor * (1.0 + size.mass * numbers['mass']),
        inertia_factor=before.inertia_factor * (1.0 + size.inertia * numbers['inertia']),
        com_shift_m=(shift[0], shift[1], shift[2]),
    )
    others = tuple(item for item in spec.links if item.name != link)
    return dataclasses.replace(spec, links=(*others, after))


def _payload(spec: ModelSpec, link: str, numbers: Mapping[str, float]) -> ModelSpec:
    place = numbers['com_x'], numbers['com_y'], numbers['com_z']
    taken = {item.name for item in spec.masses}
    name = next(
        text for count in range(len(taken) + 1) if (text := f'gap_payload_{count}') not in taken
    )
    # Beside its place squared the fit knows an inertia that is alike about all axes.
    radius = math.sqrt(max(numbers['inertia'] / numbers['mass'], 0.0))
    mass = MassSpec(name, link, numbers['mass'], place, (radius,) * 3)
    return dataclasses.replace(spec, masses=(*spec.masses, mass))


def _compensator(spec: ModelSpec, joint: str, numbers: Mapping[str, float]) -> ModelSpec:
    taken = {item.name for item in spec.compensators}
    name = next(
        text
        for count in range(len(taken) + 1)
        if (text := f'gap_compensator_{count}') not in taken
    )
    item = CompensatorSpec(name, joint, numbers['strength'], numbers['phase'])
    return dataclasses.replace(spec, compensators=(*spec.compensators, item))


def _rotor(spec: ModelSpec, joint: str, numbers: Mapping[str, float]) -> ModelSpec:
    joints = tuple(
        dataclasses.replace(
            item,
            drive=dataclasses.replace(
                item.drive,
                rotor_inertia_kg_m2=item.drive.rotor_inertia_kg_m2 + numbers['change'],
            ),
        )
        if item.name == joint
        else item
        for item in spec.joints
    )
    return dataclasses.replace(spec, joints=joints)


def _stiffness(spec: ModelSpec, joint: str, numbers: Mapping[str, float]) -> ModelSpec:
    """Return a spec with the spring that was found instead of the one there was."""
    joints = tuple(
        dataclasses.replace(
            item,
            drive=dataclasses.replace(
                item.drive, spring=Spring(numbers['stiffness'], item.drive.spring.damping)
            ),
        )
        if item.name == joint
        else item
        for item in spec.joints
    )
    return dataclasses.replace(spec, joints=joints)


IN_MODEL: Mapping[str, Callable[[ModelSpec, str, Mapping[str, float]], ModelSpec]] = {
    'payload': _payload,
    'gravity_compensator': _compensator,
    'rotor_inertia': _rotor,
    'joint_stiffness': _stiffness,
}
