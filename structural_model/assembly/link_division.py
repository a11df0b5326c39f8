"""Links as one body, or as several where a hinge or a beam divides them."""

import numpy as np
import pinocchio as pin

from modal_core.errors import ModelError
from structural_model.assembly.beam_division import divide_by_beam
from structural_model.assembly.builder import ArmBuilder
from structural_model.assembly.hinge_division import divide_at_hinges
from structural_model.assembly.stations import Divided, Station
from structural_model.description import BeamSpec, HingeSpec, ModelSpec, RigidRobot


def divide(
    arm: ArmBuilder,
    robot: RigidRobot,
    spec: ModelSpec,
    index: int,
    body: int,
    inertia: pin.Inertia,
) -> Divided:
    """Give a moving link its bodies: one, or several when a hinge or beam divides it.

    Parameters
    ----------
    arm : ArmBuilder
        Grows by them.
    robot, spec : RigidRobot, ModelSpec
        The rigid arm and its flexibilities.
    index : int
        Moving joint of the link (0: base).
    body : int
        Joint of the expanded arm that the link begins on.
    inertia : pinocchio.Inertia
        Of the whole link.

    Raises
    ------
    ModelError
        It is divided in two ways, or a beam does not fit.
    """
    offset = np.array(spec.stands_at_m) if index == 0 and body != 0 else np.zeros(3)
    dividers: list[HingeSpec | BeamSpec] = [
        *(
            item
            for item in spec.hinges
            if arm.links[item.link][0] == index and not item.spring.rigid
        ),
        *(item for item in spec.beams if arm.links[item.link][0] == index),
    ]
    if not dividers:
        arm.append(body, inertia, offset)
        return Divided((Station(body, offset),), np.zeros(3), np.zeros(3))
    beams = [item for item in dividers if isinstance(item, BeamSpec)]
    if beams and len(dividers) > 1:
        raise ModelError(
            'a link takes either one beam or hinges',
            where=f'{arm.robot_name}: {beams[0].link}',
        )
    if beams:
        return divide_by_beam(arm, beams[0], Station(body, offset), inertia)
    hinges = [item for item in dividers if isinstance(item, HingeSpec)]
    return divide_at_hinges(arm, robot, index, hinges, Station(body, offset), inertia)
