"""Links as beams of segments."""

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from modal_core.errors import ModelError
from structural_model.assembly.axes import across
from structural_model.assembly.beam import relative_stiffness, rod_inertia, slices
from structural_model.assembly.builder import ArmBuilder
from structural_model.assembly.inertia import scaled, without
from structural_model.assembly.stations import Divided, Station
from structural_model.description import BeamSpec

Matrix = NDArray[np.float64]
MOST_SEGMENTS = 64


def divide_by_beam(
    arm: ArmBuilder, beam: BeamSpec, root: Station, inertia: pin.Inertia
) -> Divided:
    """Spread part of a link along a beam of segments; the rest rides on its ends."""
    where = f'{arm.robot_name}: beam {beam.name}'
    start = arm.in_joint(beam.link, beam.start_m)
    span = arm.in_joint(beam.link, beam.end_m) - start
    length = float(np.linalg.norm(span))
    segments_fit = 1 <= beam.elements <= MOST_SEGMENTS
    if length < 1e-6 or not segments_fit or not 0.0 <= beam.outboard_share <= 1.0:
        raise ModelError(
            f'beam needs a length, 1 to {MOST_SEGMENTS} segments, an outboard share of 0..1',
            where=where,
            found=f'{length} m, {beam.elements}, {beam.outboard_share}',
        )
    along = span / length
    rod = rod_inertia(beam.mass_kg, length, beam.gyration_m, along)
    rest = without(inertia, pin.Inertia(beam.mass_kg, start + span / 2.0, rod), where)
    stations = [root]
    arm.append(root.joint, scaled(rest, 1.0 - beam.outboard_share), root.offset)
    for node, part in enumerate(slices(beam.mass_kg, length, beam.elements)):
        if node > 0:
            place = start + span * node / beam.elements
            stations.append(_segment(arm, beam, node, stations[-1], place, along))
        own = rod_inertia(part.mass_kg, part.length_m, beam.gyration_m, along)
        body = pin.Inertia(part.mass_kg, start + along * part.centre_m, own)
        arm.append(stations[-1].joint, body, stations[-1].offset)
    tip = stations[-1]
    arm.append(tip.joint, scaled(rest, beam.outboard_share), tip.offset)
    step = length / beam.elements
    borders = tuple(step * (node - 0.5) for node in range(1, beam.elements + 1))
    return Divided(tuple(stations), start, along, borders)


def _segment(
    arm: ArmBuilder, beam: BeamSpec, node: int, last: Station, place: Matrix, along: Matrix
) -> Station:
    """Add the degrees of freedom of one beam segment."""
    first, second = across((along[0], along[1], along[2]))
    stiffness = relative_stiffness(beam, float(np.linalg.norm(_span(beam))))
    axes = (first, second, along, first, second, along)
    labels = ('bend_1', 'bend_2', 'stretch', 'turn_1', 'turn_2', 'twist')
    kept = [number for number in range(6) if np.isfinite(stiffness[number, number])]
    body, placement = last.joint, pin.SE3(np.eye(3), place - last.offset)
    dofs = []
    for number in kept:
        name = f'{beam.name}/{node}/{labels[number]}'
        body = arm.dof(body, placement, axes[number], name, None, translation=number < 3)
        placement = pin.SE3.Identity()
        dofs.append(len(arm.names) - 1)
    block = stiffness[np.ix_(kept, kept)]
    arm.springs.append((dofs, block, beam.damping_s * block))
    return Station(body, place)


def _span(beam: BeamSpec) -> Matrix:
    return np.asarray((np.array(beam.end_m) - np.array(beam.start_m)) / beam.elements)
