"""Expand the rigid arm by its flexible degrees of freedom, as one larger pinocchio model.

Every flexible degree of freedom becomes an own joint, so that pinocchio's algorithms give the
mass matrix, Jacobians, gravity and velocity terms of the flexible arm.  Order: base, then for each
joint its two bearing tilts, its drive, and whatever divides or hangs on the link behind it.

References
----------
Huynh et al. (2020), doi:10.3390/app10186383 (three degrees of freedom a joint); Mousavi et al.
(2018), doi:10.1007/s00170-017-0052-0 (beams between joints).
"""

from dataclasses import dataclass, field
from functools import cache, cached_property
import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from modal_core.errors import ModelError
from structural_model.beam import relative_stiffness, rod_inertia, slices
from structural_model.coupling import AxisMap
from structural_model.drives import add_drive_springs
from structural_model.inertia import point_mass, scaled, without
from structural_model.spec import BeamSpec, Drive, HingeSpec, ModelSpec, Spring, Vector
from structural_model.stations import Divided, Station
from structural_model.urdf import Joint, RigidRobot

Matrix = NDArray[np.float64]
MOST_SEGMENTS = 64


@dataclass(frozen=True)
class Assembly:
    """The expanded arm.

    Parameters
    ----------
    model : pinocchio.Model
        One coordinate per joint; nq = nv.
    dof_names : tuple of str
        Flexible degrees of freedom, in the order of M, C, K.
    flexible : (n_flexible,) int array
        Place of those before the motors in pinocchio's vectors.
    drives : (n_joints,) int array
        Place of the robot joints in pinocchio's vectors.
    motors : (n_motors,) int array
        Joints whose servo is not stiff; their motor deviations are the last rows of M, C, K.
    motor_inertia : (n_motors,) array [kg m²]
        Rotor inertia seen behind the gear.
    stiffness, damping : (n_dof, n_dof) array
        Of springs and dampers; pose-independent.
    links : dict
        Link of the URDF to its moving joint (0: base) and placement in that joint's frame.
    divided : dict
        Moving joint (0: base) to its bodies.
    """

    model: pin.Model
    dof_names: tuple[str, ...]
    flexible: NDArray[np.intp]
    drives: NDArray[np.intp]
    motors: NDArray[np.intp]
    motor_inertia: Matrix
    stiffness: Matrix
    damping: Matrix
    links: dict[str, tuple[int, pin.SE3]]
    divided: dict[int, Divided]

    @cached_property
    def sensor_maps(self) -> dict[Any, Any]:
        """Memory of ``sensing.sensor_map``."""
        return {}

    @cached_property
    def _local(self) -> threading.local:
        return threading.local()

    @property
    def data(self) -> pin.Data:
        """Work space of pinocchio's algorithms, one per thread."""
        if not hasattr(self._local, 'data'):
            self._local.data = self.model.createData()
        return self._local.data

    def link(self, name: str) -> tuple[int, pin.SE3]:
        """Return a link's moving joint (0: base) and its placement in that joint's frame.

        Raises
        ------
        ModelError
            No such link.
        """
        if name not in self.links:
            raise ModelError('unknown link', found=name, expected=', '.join(self.links))
        return self.links[name]

    def attach(self, link: str, position: Matrix) -> tuple[int, pin.SE3]:
        """Return the pinocchio joint a point of a link rides on and the link frame moved there.

        Raises
        ------
        ModelError
            No such link.
        """
        parent, placement = self.link(link)
        point = placement.act(position)
        station = self.divided[parent].station(point)
        return station.joint, pin.SE3(placement.rotation, point - station.offset)


@cache
def across(axis: Vector) -> tuple[Matrix, Matrix]:
    """Return the two unit vectors across an axis, cyclic: z gives x and y, y gives z and x.

    Parameters
    ----------
    axis : (3,) tuple
        Need not be a unit vector.
    """
    unit = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    helper = np.zeros(3)
    helper[(int(np.argmax(np.abs(unit))) + 1) % 3] = 1.0
    first = helper - (helper @ unit) * unit
    first /= np.linalg.norm(first)
    second = np.cross(unit, first)
    first.flags.writeable = second.flags.writeable = False
    return first, second


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
    return _Assembler(robot, spec, axes).run()


@dataclass
class _Assembler:
    robot: RigidRobot
    spec: ModelSpec
    axes: AxisMap
    model: pin.Model = field(default_factory=pin.Model)
    names: list[str] = field(default_factory=list)
    places: list[int] = field(default_factory=list)
    springs: list[tuple[list[int], Matrix, Matrix]] = field(default_factory=list)
    divided: dict[int, Divided] = field(default_factory=dict)
    drives: list[int] = field(default_factory=list)

    def run(self) -> Assembly:
        self._check_names()
        self.model.gravity.linear = np.array(self.spec.gravity_m_s2)
        self.links = _links(self.robot)
        inertias = self._inertias()
        self._divide(0, self._base(), inertias[0])
        for index, joint in enumerate(self.robot.joints, start=1):
            self._divide(index, self._moving_joint(index, joint), inertias[index])
        self._masses()
        self._absorbers()
        return self._finish()

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
                body = self._dof(body, placement, axis, name, spring, translation=False)
                placement = pin.SE3.Identity()
        name = f'{joint.name}/drive'
        body = self._joint(body, placement, np.array(joint.axis), name, joint.prismatic)
        self.drives.append(self.model.joints[body].idx_v)
        if not flexible.drive.spring.rigid:
            self.names.append(name)
            self.places.append(self.drives[-1])
        return body

    def _check_names(self) -> None:
        joints, links = set(self.robot.joint_names), set(self.robot.link_names)
        asked = [('joint', item.name) for item in self.spec.joints]
        asked += [('joint', name) for rod in self.spec.rods for name, _ in rod.weights]
        asked += [('joint', item.joint) for item in self.spec.compensators]
        asked += [('link', item.name) for item in self.spec.links]
        for parts in (self.spec.masses, self.spec.hinges, self.spec.beams, self.spec.absorbers):
            asked += [('link', item.link) for item in parts]
        for kind, name in asked:
            known = joints if kind == 'joint' else links
            if name not in known:
                raise ModelError(
                    f'unknown {kind}', where=self.robot.name, found=name, expected=sorted(known)
                )
        missing = joints - {item.name for item in self.spec.joints}
        if missing:
            raise ModelError('joints without a spec', where=self.robot.name, found=sorted(missing))

    def _inertias(self) -> list[pin.Inertia]:
        """Return the inertia of every moving body, with the spec's corrections."""
        inertias = [pin.Inertia(inertia) for inertia in self.robot.model.inertias]
        for item in self.spec.links:
            index, placement = self.links[item.name]
            found = inertias[index]
            if abs(placement.translation).max() > 0.0 and item.name not in self._own_frames():
                raise ModelError(
                    'corrections belong to the moving link',
                    where=f'{self.robot.name}: {item.name}',
                    advice='name the link behind the moving joint, not one fixed to it',
                )
            inertias[index] = pin.Inertia(
                found.mass * item.mass_factor,
                found.lever + np.array(item.com_shift_m),
                found.inertia * item.mass_factor * item.inertia_factor,
            )
        return inertias

    def _own_frames(self) -> set[str]:
        return {
            name
            for name, (_, placement) in self.links.items()
            if placement.isApprox(pin.SE3.Identity())
        }

    def _joint(
        self, body: int, placement: pin.SE3, axis: Matrix, name: str, translation: bool
    ) -> int:
        kind = pin.JointModelPrismaticUnaligned if translation else pin.JointModelRevoluteUnaligned
        return int(self.model.addJoint(body, kind(np.asarray(axis, dtype=float)), placement, name))

    def _dof(
        self,
        body: int,
        placement: pin.SE3,
        axis: Matrix,
        name: str,
        spring: Spring | None,
        translation: bool,
    ) -> int:
        """Add one flexible degree of freedom; ``spring`` None when a block stiffness follows."""
        joint = self._joint(body, placement, axis, name, translation)
        self.names.append(name)
        self.places.append(self.model.joints[joint].idx_v)
        if spring is not None:
            self._spring([len(self.names) - 1], [[1.0]], spring)
        return joint

    def _spring(self, dofs: list[int], shape: object, spring: Spring) -> None:
        if not (spring.stiffness > 0.0 and spring.damping >= 0.0):
            raise ModelError(
                'spring without positive stiffness or with negative damping',
                where=f'{self.robot.name}: {self.names[dofs[0]]}',
                found=f'{spring.stiffness}, {spring.damping}',
            )
        block = np.asarray(shape, dtype=float)
        self.springs.append((dofs, spring.stiffness * block, spring.damping * block))

    def _base(self) -> int:
        body, placement = 0, pin.SE3(np.eye(3), np.array(self.spec.base.position_m))
        for number, spring in enumerate(self.spec.base.springs):
            if spring.rigid:
                continue
            axis = np.eye(3)[number % 3]
            name = f'base/{("tx", "ty", "tz", "rx", "ry", "rz")[number]}'
            body = self._dof(body, placement, axis, name, spring, translation=number < 3)
            placement = pin.SE3.Identity()
        return body

    def _divide(self, index: int, body: int, inertia: pin.Inertia) -> None:
        """Give a moving link its bodies: one, or several when a hinge or beam divides it."""
        offset = np.array(self.spec.base.position_m) if index == 0 and body != 0 else np.zeros(3)
        dividers: list[HingeSpec | BeamSpec] = [
            *(
                item
                for item in self.spec.hinges
                if self.links[item.link][0] == index and not item.spring.rigid
            ),
            *(item for item in self.spec.beams if self.links[item.link][0] == index),
        ]
        if not dividers:
            self._append(body, inertia, offset)
            self.divided[index] = Divided((Station(body, offset),), np.zeros(3), np.zeros(3))
            return
        beams = [item for item in dividers if isinstance(item, BeamSpec)]
        if beams and len(dividers) > 1:
            raise ModelError(
                'a link takes either one beam or hinges',
                where=f'{self.robot.name}: {beams[0].link}',
            )
        if beams:
            self.divided[index] = self._beam(beams[0], Station(body, offset), inertia)
        else:
            hinges = [item for item in dividers if isinstance(item, HingeSpec)]
            self.divided[index] = self._hinges(index, hinges, Station(body, offset), inertia)

    def _append(self, body: int, inertia: pin.Inertia, offset: Matrix) -> None:
        """Add an inertia given in the link frame to a body whose origin is at ``offset``."""
        if inertia.mass == 0.0:
            return
        moved = pin.Inertia(inertia.mass, inertia.lever - offset, inertia.inertia)
        self.model.appendBodyToJoint(body, moved, pin.SE3.Identity())

    def _hinges(
        self, index: int, hinges: list[HingeSpec], root: Station, inertia: pin.Inertia
    ) -> Divided:
        """Divide a link at virtual hinges, ordered along the line to the next joint."""
        direction = self._outward(index, hinges[0])
        places = [self._in_joint(item.link, item.position_m) for item in hinges]
        order = sorted(range(len(hinges)), key=lambda number: float(places[number] @ direction))
        stations, borders, share = [root], [], 1.0
        start = places[order[0]]
        for number in order:
            hinge, place = hinges[number], places[number]
            rotation = self.links[hinge.link][1].rotation
            inboard = share * (1.0 - hinge.outboard_share)
            self._append(stations[-1].joint, scaled(inertia, inboard), stations[-1].offset)
            share -= inboard
            body = self._dof(
                stations[-1].joint,
                pin.SE3(np.eye(3), place - stations[-1].offset),
                rotation @ _unit(hinge.axis, f'{self.robot.name}: {hinge.name}'),
                hinge.name,
                hinge.spring,
                hinge.translation,
            )
            stations.append(Station(body, place))
            borders.append(float((place - start) @ direction))
        self._append(stations[-1].joint, scaled(inertia, share), stations[-1].offset)
        return Divided(tuple(stations), start, direction, tuple(borders))

    def _in_joint(self, link: str, position: Vector) -> Matrix:
        return np.asarray(self.links[link][1].act(np.array(position)))

    def _outward(self, index: int, hinge: HingeSpec) -> Matrix:
        """Return the unit vector from a link's joint towards the next one (or past the hinge)."""
        ends = [
            np.asarray(self.robot.model.jointPlacements[child].translation)
            for child in range(1, self.robot.model.njoints)
            if int(self.robot.model.parents[child]) == index
        ]
        end = ends[0] if ends else self._in_joint(hinge.link, hinge.position_m)
        length = float(np.linalg.norm(end))
        return end / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])

    def _beam(self, beam: BeamSpec, root: Station, inertia: pin.Inertia) -> Divided:
        where = f'{self.robot.name}: beam {beam.name}'
        start = self._in_joint(beam.link, beam.start_m)
        span = self._in_joint(beam.link, beam.end_m) - start
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
        self._append(root.joint, scaled(rest, 1.0 - beam.outboard_share), root.offset)
        for node, part in enumerate(slices(beam.mass_kg, length, beam.elements)):
            if node > 0:
                place = start + span * node / beam.elements
                stations.append(self._segment(beam, node, stations[-1], place, along))
            own = rod_inertia(part.mass_kg, part.length_m, beam.gyration_m, along)
            body = pin.Inertia(part.mass_kg, start + along * part.centre_m, own)
            self._append(stations[-1].joint, body, stations[-1].offset)
        tip = stations[-1]
        self._append(tip.joint, scaled(rest, beam.outboard_share), tip.offset)
        step = length / beam.elements
        borders = tuple(step * (node - 0.5) for node in range(1, beam.elements + 1))
        return Divided(tuple(stations), start, along, borders)

    def _segment(
        self, beam: BeamSpec, node: int, last: Station, place: Matrix, along: Matrix
    ) -> Station:
        """Add the degrees of freedom of one beam segment."""
        first, second = across((along[0], along[1], along[2]))
        stiffness = relative_stiffness(beam, float(np.linalg.norm(self._span(beam))))
        axes = (first, second, along, first, second, along)
        labels = ('bend_1', 'bend_2', 'stretch', 'turn_1', 'turn_2', 'twist')
        kept = [number for number in range(6) if np.isfinite(stiffness[number, number])]
        body, placement = last.joint, pin.SE3(np.eye(3), place - last.offset)
        dofs = []
        for number in kept:
            name = f'{beam.name}/{node}/{labels[number]}'
            body = self._dof(body, placement, axes[number], name, None, translation=number < 3)
            placement = pin.SE3.Identity()
            dofs.append(len(self.names) - 1)
        block = stiffness[np.ix_(kept, kept)]
        self.springs.append((dofs, block, beam.damping_s * block))
        return Station(body, place)

    def _span(self, beam: BeamSpec) -> Matrix:
        return np.asarray((np.array(beam.end_m) - np.array(beam.start_m)) / beam.elements)

    def _masses(self) -> None:
        for item in self.spec.masses:
            joint, placement = self._attach(item.link, item.position_m)
            inertia = pin.Inertia(
                item.mass_kg,
                np.zeros(3),
                item.mass_kg * np.diag(np.array(item.gyration_m) ** 2),
            )
            self.model.appendBodyToJoint(joint, inertia, placement)

    def _attach(self, link: str, position: Vector) -> tuple[int, pin.SE3]:
        index, placement = self.links[link]
        point = np.asarray(placement.act(np.array(position)))
        station = self.divided[index].station(point)
        return station.joint, pin.SE3(placement.rotation, point - station.offset)

    def _absorbers(self) -> None:
        for item in self.spec.absorbers:
            if item.mass_kg <= 0.0:
                raise ModelError('absorber without mass', where=item.name, found=item.mass_kg)
            joint, placement = self._attach(item.link, item.position_m)
            mass = point_mass(item.mass_kg, np.zeros(3))
            if item.spring.rigid:
                self.model.appendBodyToJoint(joint, mass, placement)
                continue
            axis = _unit(item.axis, f'{self.robot.name}: {item.name}')
            body = self._dof(joint, placement, axis, item.name, item.spring, translation=True)
            self._append(body, mass, np.zeros(3))

    def _finish(self) -> Assembly:
        """Sort by pinocchio's order, append the motors, add up the springs."""
        order = np.argsort(self.places) if self.names else np.array([], dtype=int)
        names = [self.names[number] for number in order]
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
        for dofs, k_block, c_block in self.springs:
            at = np.ix_(rank[dofs], rank[dofs])
            stiffness[at] += k_block
            damping[at] += c_block
        add_drive_springs(stiffness, damping, names, self.robot, self.spec, self.axes)
        return Assembly(
            model=self.model,
            dof_names=tuple(names),
            flexible=np.array(self.places, dtype=np.intp)[order],
            drives=np.array(self.drives, dtype=np.intp),
            motors=np.array(motors, dtype=np.intp),
            motor_inertia=np.array(inertia),
            stiffness=stiffness,
            damping=damping,
            links=self.links,
            divided=self.divided,
        )

    def _drive(self, joint: str) -> Drive:
        return next(item.drive for item in self.spec.joints if item.name == joint)


def _links(robot: RigidRobot) -> dict[str, tuple[int, pin.SE3]]:
    links = {}
    for frame in robot.model.frames:
        if frame.type == pin.FrameType.BODY:
            links[frame.name] = (int(frame.parentJoint), pin.SE3(frame.placement))
    return links


def _unit(axis: Vector, where: str) -> Matrix:
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        raise ModelError('axis is zero', where=where)
    return np.asarray(np.array(axis) / length)
