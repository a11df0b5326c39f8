"""What the spec says of the rigid arm: names that must exist, inertias put right."""

import numpy as np
import pinocchio as pin

from modal_core.errors import ModelError
from structural_model.description import ModelSpec, RigidRobot

Links = dict[str, tuple[int, pin.SE3]]


def correctable_links(robot: RigidRobot) -> tuple[str, ...]:
    """Return the links whose masses may be corrected: they lie in the frame of a moving body."""
    links = robot.links
    return tuple(
        name for name in robot.link_names if links[name][0] > 0 and _is_of_body(links[name][1])
    )


def _is_of_body(placement: pin.SE3) -> bool:
    return bool(abs(placement.translation).max() == 0.0 or placement.isApprox(pin.SE3.Identity()))


def check_names(robot: RigidRobot, spec: ModelSpec) -> None:
    """Raise `ModelError` where a spec names a joint or link that the robot does not have."""
    joints, links = set(robot.joint_names), set(robot.link_names)
    asked = [('joint', item.name) for item in spec.joints]
    asked += [('joint', name) for rod in spec.rods for name, _ in rod.weights]
    asked += [('joint', item.joint) for item in spec.compensators]
    asked += [('link', item.name) for item in spec.links]
    for parts in (spec.masses, spec.hinges, spec.beams, spec.absorbers, spec.cables):
        asked += [('link', item.link) for item in parts]
    for kind, name in asked:
        known = joints if kind == 'joint' else links
        if name not in known:
            raise ModelError(
                f'unknown {kind}', where=robot.name, found=name, expected=sorted(known)
            )
    missing = joints - {item.name for item in spec.joints}
    if missing:
        raise ModelError('joints without a spec', where=robot.name, found=sorted(missing))


def corrected_inertias(robot: RigidRobot, spec: ModelSpec, links: Links) -> list[pin.Inertia]:
    """Return the inertia of every moving body, with the spec's corrections."""
    inertias = [pin.Inertia(inertia) for inertia in robot.model.inertias]
    for item in spec.links:
        index, placement = links[item.name]
        found = inertias[index]
        if not _is_of_body(placement):
            raise ModelError(
                'corrections belong to the moving link',
                where=f'{robot.name}: {item.name}',
                advice='name the link behind the moving joint, not one fixed to it',
            )
        inertias[index] = pin.Inertia(
            found.mass * item.mass_factor,
            found.lever + np.array(item.com_shift_m),
            found.inertia * item.mass_factor * item.inertia_factor,
        )
    return inertias
