"""Links divided at virtual hinges."""

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from structural_model.assembly.axes import unit
from structural_model.assembly.builder import ArmBuilder
from structural_model.assembly.inertia import scaled
from structural_model.assembly.stations import Divided, Station
from structural_model.description import HingeSpec, RigidRobot

Matrix = NDArray[np.float64]


def divide_at_hinges(
    arm: ArmBuilder,
    robot: RigidRobot,
    index: int,
    hinges: list[HingeSpec],
    root: Station,
    inertia: pin.Inertia,
) -> Divided:
    """Divide a link at virtual hinges, ordered along the line to the next joint."""
    direction = _outward(arm, robot, index, hinges[0])
    places = [arm.in_joint(item.link, item.position_m) for item in hinges]
    order = sorted(range(len(hinges)), key=lambda number: float(places[number] @ direction))
    stations, borders, share = [root], [], 1.0
    start = places[order[0]]
    for number in order:
        hinge, place = hinges[number], places[number]
        rotation = arm.links[hinge.link][1].rotation
        inboard = share * (1.0 - hinge.outboard_share)
        arm.append(stations[-1].joint, scaled(inertia, inboard), stations[-1].offset)
        share -= inboard
        body = arm.dof(
            stations[-1].joint,
            pin.SE3(np.eye(3), place - stations[-1].offset),
            rotation @ unit(hinge.axis, f'{arm.robot_name}: {hinge.name}'),
            hinge.name,
            hinge.spring,
            hinge.translation,
        )
        stations.append(Station(body, place))
        borders.append(float((place - start) @ direction))
    arm.append(stations[-1].joint, scaled(inertia, share), stations[-1].offset)
    return Divided(tuple(stations), start, direction, tuple(borders))


def _outward(arm: ArmBuilder, robot: RigidRobot, index: int, hinge: HingeSpec) -> Matrix:
    """Return the unit vector from a link's joint towards the next one (or past the hinge)."""
    ends = [
        np.asarray(robot.model.jointPlacements[child].translation)
        for child in range(1, robot.model.njoints)
        if int(robot.model.parents[child]) == index
    ]
    end = ends[0] if ends else arm.in_joint(hinge.link, hinge.position_m)
    length = float(np.linalg.norm(end))
    return end / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])
