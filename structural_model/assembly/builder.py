"""A pinocchio model that grows joint by joint, with springs on its degrees of freedom."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from structural_model.description import check_spring, Spring, Vector

Matrix = NDArray[np.float64]


@dataclass
class ArmBuilder:
    """What has been added so far.

    Parameters
    ----------
    robot_name : str
        For errors.
    links : dict
        Link of the URDF to its moving joint (0: base) and placement in that joint's frame.
    model : pinocchio.Model
        Grows.
    names, places : list
        Of flexible degrees of freedom, in the order in which they came; place in pinocchio's
        vectors.
    own_springs : list of (number of a degree of freedom, spring)
        On one alone.
    springs : list of (numbers of degrees of freedom, stiffness, damping)
        Blocks on several.
    """

    robot_name: str
    links: dict[str, tuple[int, pin.SE3]]
    model: pin.Model = field(default_factory=pin.Model)
    names: list[str] = field(default_factory=list)
    places: list[int] = field(default_factory=list)
    own_springs: list[tuple[int, Spring]] = field(default_factory=list)
    springs: list[tuple[list[int], Matrix, Matrix]] = field(default_factory=list)

    def joint(
        self, body: int, placement: pin.SE3, axis: Matrix, name: str, translation: bool
    ) -> int:
        """Add a joint and return it."""
        kind = pin.JointModelPrismaticUnaligned if translation else pin.JointModelRevoluteUnaligned
        return int(self.model.addJoint(body, kind(np.asarray(axis, dtype=float)), placement, name))

    def dof(
        self,
        body: int,
        placement: pin.SE3,
        axis: Matrix,
        name: str,
        spring: Spring | None,
        translation: bool,
    ) -> int:
        """Add one flexible degree of freedom; ``spring`` None when a block stiffness follows.

        Raises
        ------
        ModelError
            The spring pushes away, or drives.
        """
        joint = self.joint(body, placement, axis, name, translation)
        self.names.append(name)
        self.places.append(self.model.joints[joint].idx_v)
        if spring is not None:
            check_spring(spring, f'{self.robot_name}: {name}')
            self.own_springs.append((len(self.names) - 1, spring))
        return joint

    def append(self, body: int, inertia: pin.Inertia, offset: Matrix) -> None:
        """Add an inertia given in the link frame to a body whose origin is at ``offset``."""
        if inertia.mass == 0.0:
            return
        moved = pin.Inertia(inertia.mass, inertia.lever - offset, inertia.inertia)
        self.model.appendBodyToJoint(body, moved, pin.SE3.Identity())

    def in_joint(self, link: str, position: Vector) -> Matrix:
        """Return a point of a link in the frame of its moving joint, (3,) [m]."""
        return np.asarray(self.links[link][1].act(np.array(position)))
