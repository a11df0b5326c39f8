"""Read a URDF that may come from anywhere: no entities, no missing inertias, one clear error."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
import math
from pathlib import Path
import re
from xml.etree.ElementTree import Element, ParseError, tostring

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import fromstring
import numpy as np
import pinocchio as pin

from modal_core.errors import ModelError, SettingsError
from modal_core.files.small_file import read_bytes
from structural_model.description.link_tree import link_of, LinkTree

LARGEST_FILE_BYTES = 5_000_000
DEEPEST, MOST_LINKS = 16, 1000
"""Elements inside one another (a URDF needs five) and bodies: beyond, reading takes minutes."""
LARGEST = 1e15
"""Of a place [m], an angle [rad], a mass [kg] and a moment of inertia [kg m²], whose squares and
products must stay numbers."""
MOVING = ('revolute', 'continuous', 'prismatic')
NEEDED = {'link': ('inertial',), 'joint': ('origin', 'parent', 'child', 'axis', 'limit')}
"""What pinocchio reads of a robot; its parser tells of the rest in lines of its own, or leaves out
what it is part of."""
TENSOR = ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz')
NUMBER = re.compile(r'[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?')
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Joint:
    """A moving joint as the URDF describes it.

    Parameters
    ----------
    name : str
        Joint name.
    axis : (3,) tuple
        Unit vector in the joint frame.
    prismatic : bool
        Slides instead of turning.
    low, high : float [rad] or [m]
        Range; infinite for a continuous joint.
    velocity, effort : float [rad/s], [N m]
        Limits.
    """

    name: str
    axis: Vector
    prismatic: bool
    low: float
    high: float
    velocity: float
    effort: float


@dataclass(frozen=True)
class Shape:
    """A capsule, sphere (zero length) or box fixed to a link.

    Parameters
    ----------
    link : str
        Link it is fixed to.
    rotation : (3, 3) array
        Axes of the shape in the link frame; a capsule lies along its z.
    position : (3,) array [m]
        Centre in the link frame.
    radius, length : float [m]
        Of a capsule, length without the round ends; of a box 0.
    box : (3,) tuple [m] or None
        Edge lengths of a box.
    """

    link: str
    rotation: np.ndarray
    position: np.ndarray
    radius: float
    length: float
    box: Vector | None = None


@dataclass(frozen=True)
class RigidRobot:
    """The rigid arm: what the URDF says.

    Parameters
    ----------
    name : str
        Robot name.
    joints : tuple of Joint
        In pinocchio's order.
    link_names : tuple of str
        All links, the base first and the tip last, whatever their order in the file.
    shapes : tuple of Shape
        From the collision elements.
    model : pinocchio.Model
        One degree of freedom per joint.
    text : bytes
        The URDF itself.
    """

    name: str
    joints: tuple[Joint, ...]
    link_names: tuple[str, ...]
    shapes: tuple[Shape, ...]
    model: pin.Model
    text: bytes = b''

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Moving joints in order."""
        return tuple(joint.name for joint in self.joints)

    @cached_property
    def links(self) -> dict[str, tuple[int, pin.SE3]]:
        """Every link with its moving joint (0: base) and placement in that joint's frame."""
        return {
            frame.name: (int(frame.parentJoint), pin.SE3(frame.placement))
            for frame in self.model.frames
            if frame.type == pin.FrameType.BODY
        }

    @cached_property
    def tip_frame(self) -> int:
        """Number of the last link's frame; a joint may be called as a link."""
        return int(self.model.getFrameId(self.link_names[-1], pin.FrameType.BODY))

    @property
    def reach_m(self) -> float:
        """Farthest that the origin of a link may be from the base's: steps between them, added."""
        steps = [float(np.linalg.norm(place.translation)) for place in self.model.jointPlacements]
        reach = [0.0]
        for joint in range(1, self.model.njoints):
            reach.append(reach[self.model.parents[joint]] + steps[joint])
        ends = (
            reach[frame.parentJoint] + float(np.linalg.norm(frame.placement.translation))
            for frame in self.model.frames
        )
        return float(max(ends))


def load_urdf(path: str | Path) -> RigidRobot:
    """Read a URDF file.

    Raises
    ------
    ModelError
        The file is missing, too large, not XML, carries entities, or is not a usable robot: a body
        that moves without inertia, an inertia that no body can have, an unsupported joint type.
    """
    return parse_urdf(read_urdf_file(path), str(path))


def read_urdf_file(path: str | Path) -> bytes:
    """Return the text of a URDF file.

    Raises
    ------
    ModelError
        It is missing or too large.
    """
    try:
        return read_bytes(Path(path), LARGEST_FILE_BYTES)
    except SettingsError as error:
        raise ModelError(f'URDF {error.what}', where=path, expected=error.expected) from error


def parse_urdf(text: bytes, where: str) -> RigidRobot:
    """Parse URDF text; see ``load_urdf``."""
    root = read_urdf(text, where)
    joints = _joints(root, where)
    _leave_out_weightless(root, where)
    _check_places(root, where)
    shapes = _shapes(root, where)
    link_names = LinkTree.of(root).in_order()
    model = _pinocchio_model(root, where)
    _check_bodies(root, model, where)
    names = list(model.names)[1:]
    missing = sorted(set(joints) - set(names))
    if missing or len(names) != len(joints):
        raise ModelError('URDF is not one tree', where=where, found=missing or names)
    return RigidRobot(
        name=root.get('name', Path(where).parent.name),
        joints=tuple(joints[name] for name in names),
        link_names=link_names,
        shapes=shapes,
        model=model,
        text=text,
    )


def read_urdf(text: bytes, where: str) -> Element:
    """Return the elements of a URDF that is one tree of links and no deeper than any robot.

    Raises
    ------
    ModelError
        Not XML, carries entities, not a URDF, too long, or not one tree.
    """
    try:
        root: Element = fromstring(text, forbid_dtd=True)
    except DefusedXmlException as error:
        raise ModelError('URDF carries a DTD or entities, refused', where=where) from error
    except (ParseError, ValueError) as error:
        raise ModelError('URDF is not XML', where=where, found=error) from error
    if root.tag != 'robot':
        raise ModelError('not a URDF', where=where, expected='<robot>')
    _check_extent(root, where)
    if any('xacro}' in str(element.tag) for element in root.iter()):
        raise ModelError(
            'a xacro that is not expanded',
            where=where,
            expected='a URDF',
            advice='run xacro on it, and read what that writes',
        )
    _check_tree(root, where)
    return root


def numbers(
    text: str | None,
    count: int,
    default: tuple[float, ...],
    where: str,
    largest: float = np.finfo(float).max,
) -> np.ndarray:
    """Return ``count`` numbers of an attribute, or the default when it is absent.

    Raises
    ------
    ModelError
        Another count, a magnitude above the largest, or what only Python takes for a number.
    """
    if text is None:
        return np.array(default)
    words = text.split()
    values = np.array([float(word) if NUMBER.fullmatch(word) else math.nan for word in words])
    # Written so that NaN is refused too.
    if len(values) != count or not (np.abs(values) <= largest).all():
        raise ModelError('bad numbers', where=where, found=text[:80], expected=f'{count} numbers')
    return values


def _check_extent(root: Element, where: str) -> None:
    """Refuse what is deeper or longer than any robot, before anything walks through it."""
    if len(root.findall('link')) > MOST_LINKS or len(root.findall('joint')) > MOST_LINKS:
        raise ModelError('URDF too long', where=where, expected=f'at most {MOST_LINKS} links')
    level = list(root)
    for _ in range(DEEPEST):
        level = [child for element in level for child in element]
    if level:
        raise ModelError(
            'URDF nested too deeply', where=where, expected=f'at most {DEEPEST} levels'
        )


def _joints(root: Element, where: str) -> dict[str, Joint]:
    joints: dict[str, Joint] = {}
    for element in root.findall('joint'):
        name, kind = element.get('name', ''), element.get('type', '')
        place = f'{where}: joint {name}'
        if kind == 'fixed':
            continue
        if kind not in MOVING or element.find('mimic') is not None:
            raise ModelError(
                'unsupported joint',
                where=place,
                found=kind if element.find('mimic') is None else 'mimic',
                expected=', '.join((*MOVING, 'fixed')),
            )
        if name in joints:
            raise ModelError('joint named twice', where=place)
        joints[name] = _joint(element, name, kind, place)
    if not joints:
        raise ModelError('URDF has no moving joint', where=where)
    return joints


def _joint(element: Element, name: str, kind: str, where: str) -> Joint:
    axis_element = element.find('axis')
    text = None if axis_element is None else axis_element.get('xyz')
    axis = numbers(text, 3, (1.0, 0.0, 0.0), where)
    norm = float(np.linalg.norm(axis))
    if norm < 1e-9:
        raise ModelError('joint axis is zero', where=where)
    limit = element.find('limit')
    attributes = {} if limit is None else limit.attrib
    if limit is None and kind != 'continuous':
        raise ModelError('joint has no limit', where=where)

    def value(key: str, default: float) -> float:
        return float(numbers(attributes.get(key), 1, (default,), f'{where}: limit {key}')[0])

    low, high = value('lower', -math.inf), value('upper', math.inf)
    if kind == 'continuous':
        low, high = -math.inf, math.inf
    if not low < high:
        raise ModelError('joint range is empty', where=where, found=f'{low} to {high}')
    x, y, z = (float(part) for part in axis / norm)
    return Joint(
        name=name,
        axis=(x, y, z),
        prismatic=kind == 'prismatic',
        low=low,
        high=high,
        velocity=value('velocity', math.inf),
        effort=value('effort', math.inf),
    )


def _check_tree(root: Element, where: str) -> None:
    """Every joint joins two known links, and every link but one hangs on one joint."""
    links = [link.get('name', '') for link in root.findall('link')]
    for name in links:
        if links.count(name) > 1 or not name:
            raise ModelError('link named twice or not at all', where=where, found=name)
    children = []
    for joint in root.findall('joint'):
        for role in ('parent', 'child'):
            if link_of(joint, role) not in links:
                raise ModelError(
                    f'{role} of a joint is not a link',
                    where=f'{where}: joint {joint.get("name")}',
                    found=link_of(joint, role),
                )
        children.append(link_of(joint, 'child'))
    roots = [name for name in links if name not in children]
    twice = [name for name in set(children) if children.count(name) > 1]
    if len(roots) != 1 or twice:
        raise ModelError(
            'URDF is not one tree',
            where=where,
            found=f'roots {roots[:5]}, links on two joints {twice[:5]}',
            expected='one root, every other link on one joint',
        )


def _leave_out_weightless(root: Element, where: str) -> None:
    """Take the inertias of mass zero out, as tool frames and dummy links carry them."""
    for link in root.findall('link'):
        inertial = link.find('inertial')
        if inertial is None:
            continue
        place = f'{where}: link {link.get("name", "")}'
        mass_element, tensor = inertial.find('mass'), inertial.find('inertia')
        if mass_element is None or tensor is None:
            raise ModelError('inertial without mass or inertia', where=place)
        for key in TENSOR:
            numbers(tensor.get(key), 1, (0.0,), f'{place}: {key}', LARGEST)
        text = mass_element.get('value')
        mass = float(numbers(text, 1, (0.0,), f'{place}: mass', LARGEST)[0])
        if mass < 0.0:
            raise ModelError('mass is negative', where=place, found=f'{mass} kg')
        if mass == 0.0:
            link.remove(inertial)


def _check_bodies(root: Element, model: pin.Model, where: str) -> None:
    """Whatever moves as one body, links fixed to each other, needs an inertia it can have.

    Of single links some are no body's in many files: dummy frames, camera mounts.
    """
    links = {joint.get('name', ''): link_of(joint, 'child') for joint in root.findall('joint')}
    for name, body in zip(list(model.names)[1:], list(model.inertias)[1:], strict=True):
        place = f'{where}: link {links.get(name, name)}, with what is fixed to it'
        if body.mass <= 0.0:
            raise ModelError(
                'link without inertia',
                where=place,
                expected='<inertial> with a mass above zero and inertia',
            )
        principal = np.linalg.eigvalsh(body.inertia)
        if principal[0] <= 0.0 or principal[0] + principal[1] < principal[2] * (1.0 - 1e-3):
            raise ModelError(
                'inertia no body can have',
                where=place,
                found=f'principal moments {np.round(principal, 6).tolist()} kg m²',
                expected='positive, each at most the sum of the other two',
            )


def _check_places(root: Element, where: str) -> None:
    """Refuse malformed places: pinocchio's parser leaves out an inertia whose place is none."""
    for kind, path in (('joint', 'origin'), ('link', 'inertial/origin')):
        for element in root.findall(kind):
            for origin in element.findall(path):
                place = f'{where}: {path} of {kind} {element.get("name")}'
                for key in ('xyz', 'rpy'):
                    numbers(origin.get(key), 3, (0.0, 0.0, 0.0), f'{place}: {key}', LARGEST)


def keep_only(root: Element, kept: Mapping[str, Sequence[str]]) -> None:
    """Leave out of a URDF all elements but some, and of these all parts but some.

    Parameters
    ----------
    root : Element
        Changed.
    kept : dict of str to sequence of str
        Parts that are kept, by element.
    """
    for element in list(root):
        for part in list(element):
            if part.tag not in kept.get(element.tag, ()):
                element.remove(part)
        if element.tag not in kept:
            root.remove(element)


def _pinocchio_model(root: Element, where: str) -> pin.Model:
    for joint in root.findall('joint'):
        if joint.get('type') == 'continuous':  # pinocchio would use cos, sin as two coordinates
            joint.set('type', 'revolute')
            limit = joint.find('limit')
            if limit is None:
                limit = Element('limit')
                joint.append(limit)
            limit.attrib.update({'lower': '-1e6', 'upper': '1e6'})
            limit.attrib.setdefault('effort', '1e12')
            limit.attrib.setdefault('velocity', '1e12')
    keep_only(root, NEEDED)
    for tensor in root.findall('link/inertial/inertia'):
        for key in TENSOR:  # an inertia with one of them missing would be left out
            tensor.attrib.setdefault(key, '0')
    try:
        model = pin.buildModelFromXML(tostring(root, encoding='unicode'))
    except (ValueError, RuntimeError) as error:
        raise ModelError(f'URDF refused: {error}', where=where) from error
    masses = [float(mass.get('value', 0.0)) for mass in root.findall('link/inertial/mass')]
    found_kg, stated_kg = sum(body.mass for body in model.inertias), sum(masses)
    if not math.isclose(found_kg, stated_kg, rel_tol=1e-6):
        raise ModelError(
            'URDF has a link whose inertia cannot be read',
            where=where,
            found=f'{found_kg:g} kg in all',
            expected=f'{stated_kg:g} kg',
        )
    return model


def _shapes(root: Element, where: str) -> tuple[Shape, ...]:
    shapes = []
    for link in root.findall('link'):
        name = link.get('name', '')
        for element in link.findall('collision'):
            shape = _shape(element, name, f'{where}: collision of {name}')
            if shape is not None:
                shapes.append(shape)
    return tuple(shapes)


def _size(text: str | None, where: str) -> float:
    value = float(numbers(text, 1, (0.0,), where)[0])
    if value <= 0.0:
        raise ModelError('size is not positive', where=where, found=value)
    return value


def _shape(element: Element, link: str, where: str) -> Shape | None:
    origin = element.find('origin')
    attributes = {} if origin is None else origin.attrib
    position = numbers(attributes.get('xyz'), 3, (0.0, 0.0, 0.0), where)
    roll_pitch_yaw = numbers(attributes.get('rpy'), 3, (0.0, 0.0, 0.0), where)
    rotation = pin.rpy.rpyToMatrix(*roll_pitch_yaw)
    cylinder = element.find('geometry/cylinder')
    sphere = element.find('geometry/sphere')
    box = element.find('geometry/box')
    if cylinder is not None:
        radius = _size(cylinder.get('radius'), where)
        length = _size(cylinder.get('length'), where)
        return Shape(link, rotation, position, radius, length)
    if sphere is not None:
        radius = _size(sphere.get('radius'), where)
        return Shape(link, rotation, position, radius, 0.0)
    if box is not None:
        x, y, z = (float(edge) for edge in numbers(box.get('size'), 3, (0.0, 0.0, 0.0), where))
        if min(x, y, z) <= 0.0:
            raise ModelError('size is not positive', where=where, found=(x, y, z))
        return Shape(link, rotation, position, 0.0, 0.0, (x, y, z))
    return None  # meshes are for display only
