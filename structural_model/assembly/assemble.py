"""Expand the rigid arm by its flexible degrees of freedom, as one larger pinocchio model.

Every flexible degree of freedom becomes an own joint, so that pinocchio's algorithms give the
mass matrix, Jacobians, gravity and velocity terms of the flexible arm.  Order: base, then for each
joint its two bearing tilts, its drive, and whatever divides or hangs on the link behind it.

References
----------
Huynh et al. (2020), doi:10.3390/app10186383 (three degrees of freedom a joint); Mousavi et al.
(2018), doi:10.1007/s00170-017-0052-0 (beams between joints).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from modal_core.errors import ModelError
from structural_model.assembly.assembled import Assembly
from structural_model.assembly.axes import across, unit
from structural_model.assembly.builder import ArmBuilder
from structural_model.assembly.drives import add_drive_springs
from structural_model.assembly.inertia import point_mass
from structural_model.assembly.link_division import divide
from structural_model.assembly.rigid_arm import check_names, corrected_inertias
from structural_model.assembly.stations import Divided
from structural_model.description import (
    AxisMap,
    Drive,
    Joint,
    ModelSpec,
    RigidRobot,
    Spring,
    Vector,
)

Matrix = NDArray[np.float64]


def assemble(robot: RigidRobot, spec: ModelSpec, axes: AxisMap) -> Assembly:
    """Expand the rigid arm.

    Parameters
    ----------
    robot : RigidRobot
        The rigid arm.
    spec : ModelSpec
        Its flexibilities.
    axes : AxisMap
        Drive springs act on controller axes.

    Raises
    ------
    ModelError
        The spec names a joint or link the robot does not have, or makes an impossible body.
    """
    check_names(robot, spec)
    return _Assembler(robot, spec, axes, ArmBuilder(robot.name, robot.links)).run()


@dataclass
class _Assembler:
    robot: RigidRobot
    spec: ModelSpec
    axes: AxisMap
    arm: ArmBuilder
    divided: dict[int, Divided] = field(default_factory=dict)
    drives: list[int] = field(default_factory=list)

    def run(self) -> Assembly:
        self.arm.model.gravity.linear = np.array(self.spec.gravity_m_s2)
        inertias = corrected_inertias(self.robot, self.spec, self.arm.links)
        self._divide(0, self._base(), inertias[0])
        for index, joint in enumerate(self.robot.joints, start=1):
            self._divide(index, self._moving_joint(index, joint), inertias[index])
        self._masses()
        self._absorbers()
        return self._finish()

    def _divide(self, index: int, body: int, inertia: pin.Inertia) -> None:
        self.divided[index] = divide(self.arm, self.robot, self.spec, index, body, inertia)

    def _moving_joint(self, index: int, joint: Joint) -> int:
        """Add tilts and drive of one robot joint and return the body behind it."""
        parent = int(self.robot.model.parents[index])
        placement = self.robot.model.jointPlacements[index]
        station = self.divided[parent].station(placement.translation)
        placement = pin.SE3(placement.rotation, placement.translation - station.offset)
        flexible = next(item for item in self.spec.joints if item.name == joint.name)
        body = station.joint
        tilts = zip(across(joint.axis), flexible.tilts, strict=True)
        for number, (axis, spring) in enumerate(tilts, start=1):
            if not spring.rigid:
                name = f'{joint.name}/tilt_{number}'
                body = self.arm.dof(body, placement, axis, name, spring, translation=False)
                placement = pin.SE3.Identity()
        name = f'{joint.name}/drive'
        if flexible.offset_rad:
            placement = placement * _moved(joint, flexible.offset_rad)
        body = self.arm.joint(body, placement, np.array(joint.axis), name, joint.prismatic)
        self.drives.append(self.arm.model.joints[body].idx_v)
        if not flexible.drive.spring.rigid:
            self.arm.names.append(name)
            self.arm.places.append(self.drives[-1])
        return body

    def _base(self) -> int:
        """Add the foundation, and the base on it; return the body the base link rides on."""
        base, under = self.spec.base, self.spec.foundation
        place, body = np.array(base.position_m), 0
        if not under.rigid:
            turned = pin.utils.rotate('z', under.yaw_rad)
            body = self._sprung(0, np.array(under.position_m), under.springs, 'foundation', turned)
            inertia = under.mass_kg * under.gyration_m**2 * np.eye(3)
            block = pin.Inertia(under.mass_kg, np.zeros(3), inertia)
            self.arm.model.appendBodyToJoint(body, block, pin.SE3.Identity())
            place = place - under.position_m
        return self._sprung(body, place, base.springs, 'base', np.eye(3))

    def _sprung(
        self, body: int, place: Matrix, springs: Sequence[Spring], name: str, axes: Matrix
    ) -> int:
        """Add six springs at a place, those that are not rigid; return the body on them."""
        placement = pin.SE3(np.eye(3), place)
        for number, spring in enumerate(springs):
            if spring.rigid:
                continue
            way = f'{name}/{("tx", "ty", "tz", "rx", "ry", "rz")[number]}'
            axis = axes[:, number % 3]
            body = self.arm.dof(body, placement, axis, way, spring, translation=number < 3)
            placement = pin.SE3.Identity()
        return body

    def _masses(self) -> None:
        for item in self.spec.masses:
            joint, placement = self._attach(item.link, item.position_m)
            inertia = pin.Inertia(
                item.mass_kg,
                np.zeros(3),
                item.mass_kg * np.diag(np.array(item.gyration_m) ** 2),
            )
            self.arm.model.appendBodyToJoint(joint, inertia, placement)

    def _attach(self, link: str, position: Vector) -> tuple[int, pin.SE3]:
        index, placement = self.arm.links[link]
        return self.divided[index].attach(placement, np.array(position))

    def _absorbers(self) -> None:
        for item in self.spec.absorbers:
            if item.mass_kg <= 0.0:
                raise ModelError('absorber without mass', where=item.name, found=item.mass_kg)
            joint, placement = self._attach(item.link, item.position_m)
            mass = point_mass(item.mass_kg, np.zeros(3))
            if item.spring.rigid:
                self.arm.model.appendBodyToJoint(joint, mass, placement)
                continue
            axis = unit(item.axis, f'{self.robot.name}: {item.name}')
            body = self.arm.dof(joint, placement, axis, item.name, item.spring, translation=True)
            self.arm.append(body, mass, np.zeros(3))

    def _finish(self) -> Assembly:
        """Sort by pinocchio's order, append the motors, add up the springs."""
        order = np.argsort(self.arm.places) if self.arm.names else np.array([], dtype=int)
        names = [self.arm.names[number] for number in order]
        rank = np.argsort(order)
        motors = [
            number
            for number, joint in enumerate(self.robot.joint_names)
            if not self._drive(joint).servo.rigid
        ]
        inertia = [
            self._drive(self.robot.joint_names[number]).gear_ratio ** 2
            * self._drive(self.robot.joint_names[number]).rotor_inertia_kg_m2
            for number in motors
        ]
        names += [f'{self.robot.joint_names[number]}/motor' for number in motors]
        size = len(names)
        stiffness, damping = np.zeros((size, size)), np.zeros((size, size))
        for dof, spring in self.arm.own_springs:
            stiffness[rank[dof], rank[dof]] += spring.stiffness
            damping[rank[dof], rank[dof]] += spring.damping
        for dofs, k_block, c_block in self.arm.springs:
            at = rank[dofs][:, None], rank[dofs]
            stiffness[at] += k_block
            damping[at] += c_block
        add_drive_springs(stiffness, damping, names, self.robot, self.spec, self.axes)
        return Assembly(
            model=self.arm.model,
            dof_names=tuple(names),
            flexible=np.array(self.arm.places, dtype=np.intp)[order],
            drives=np.array(self.drives, dtype=np.intp),
            motors=np.array(motors, dtype=np.intp),
            motor_inertia=np.array(inertia),
            stiffness=stiffness,
            damping=damping,
            links=self.arm.links,
            divided=self.divided,
        )

    def _drive(self, joint: str) -> Drive:
        return next(item.drive for item in self.spec.joints if item.name == joint)


def _moved(joint: Joint, amount: float) -> pin.SE3:
    """Return how a joint moves what it carries."""
    axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
    if joint.prismatic:
        return pin.SE3(np.eye(3), amount * axis)
    return pin.SE3(pin.exp3(amount * axis), np.zeros(3))
