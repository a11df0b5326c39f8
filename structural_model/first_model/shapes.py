"""Boxes for bodies that a URDF draws as meshes only."""

from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from structural_model.description import parse_urdf, read_urdf, RigidRobot

Array = NDArray[np.float64]
THINNEST = 0.05
"""Edge over the longest one: moments of a plate leave it no thickness, or less; chosen."""


def with_shapes(robot: RigidRobot, where: str) -> tuple[RigidRobot, tuple[str, ...]]:
    """Return a robot whose moving bodies all have a shape, and what was said of them.

    A body without one becomes the box of even density that has its mass, centre and moments of
    inertia: its edges are sqrt(6 (I_b + I_c - I_a) / m).

    Parameters
    ----------
    robot : RigidRobot
        Shapes of meshes are not among its own.
    where : str
        What to call it in errors.
    """
    drawn = {robot.links[shape.link][0] for shape in robot.shapes}
    bare = [body for body in range(1, robot.model.njoints) if body not in drawn]
    if not bare:
        return robot, ()
    root = read_urdf(robot.text, where)
    elements = {link.get('name', ''): link for link in root.findall('link')}
    names = []
    for body in bare:
        name = body_link(robot, body)
        _draw(elements[name], *box_of(robot.model.inertias[body]))
        names.append(name)
    said = f'shapes of {", ".join(names)}: boxes that have their mass and moments of inertia'
    return parse_urdf(tostring(root), where), (said,)


def body_link(robot: RigidRobot, body: int) -> str:
    """Return the link that a joint carries; their frames are one."""
    return next(
        name
        for name, (joint, place) in robot.links.items()
        if joint == body and place.isIdentity(1e-12)
    )


def box_of(inertia: pin.Inertia) -> tuple[Array, Array, Array]:
    """Return edges (3,) [m], axes (3, 3) and centre (3,) [m] of the even box of an inertia."""
    moments, axes = np.linalg.eigh(inertia.inertia)
    squares = 6.0 * (moments.sum() - 2.0 * moments) / inertia.mass
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    longest = float(np.sqrt(max(squares.max(), 0.0)))
    edges = np.sqrt(np.maximum(squares, (THINNEST * longest) ** 2))
    return edges, axes, np.asarray(inertia.lever)


def _draw(link: Element, edges: Array, axes: Array, centre: Array) -> None:
    collision = SubElement(link, 'collision')
    turned = pin.rpy.matrixToRpy(axes)
    SubElement(collision, 'origin', {'xyz': _words(centre), 'rpy': _words(turned)})
    geometry = SubElement(collision, 'geometry')
    SubElement(geometry, 'box', {'size': _words(edges)})


def _words(values: Array) -> str:
    return ' '.join(f'{value:.5g}' for value in values)
