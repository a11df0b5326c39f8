"""What an arm is made of, read from its URDF and model.yaml into plain numbers."""

from dataclasses import dataclass, field
import math
from pathlib import Path
import xml.etree.ElementTree as ET

import numpy as np
from scipy.spatial.transform import Rotation
import yaml

BASE_WAYS = ('tx', 'ty', 'tz', 'rx', 'ry', 'rz')


@dataclass
class Spring:
    """A spring beside a damper; an infinite stiffness is no joint at all."""

    k: float = math.inf
    c: float = 0.0

    @classmethod
    def of(cls, entry):
        return cls(float(entry.get('stiffness', math.inf)), float(entry.get('damping', 0.0)))


@dataclass
class Lump:
    """A rigid body: mass, centre, inertia about it."""

    mass: float
    com: np.ndarray
    inertia: np.ndarray


@dataclass
class Axis:
    """A driven joint: where it sits on the link before, its axis, what gives way there."""

    name: str
    shift: np.ndarray
    turned: np.ndarray
    axis: np.ndarray
    drive: Spring
    tilts: list
    ratio: float
    rotor: float


@dataclass
class Link:
    """A link behind its joint (None: fixed), with what is on it."""

    name: str
    joint: Axis | None
    shift: np.ndarray
    turned: np.ndarray
    lumps: list


@dataclass
class Description:
    """An arm, and what a hidden effect puts beside it (filled by ``hidden``)."""

    links: list
    base: dict
    couple: np.ndarray
    mass_damping: float
    hinge: dict | None = None
    swinging: list = field(default_factory=list)
    below: list = field(default_factory=list)
    tendons: list = field(default_factory=list)

    @property
    def axes(self):
        return [link.joint for link in self.links if link.joint is not None]

    def axis(self, name):
        return next(item for item in self.axes if item.name == name)

    def link(self, name):
        return next(item for item in self.links if item.name == name)


def read(folder):
    """Return the arm as its files state it."""
    folder = Path(folder)
    tree = ET.parse(folder / 'robot.urdf').getroot()
    model = yaml.safe_load((folder / 'model.yaml').read_text())
    links = _chain(tree, model)
    for item in model.get('masses') or []:
        size = float(item['mass_kg'])
        inertia = np.diag(size * np.array(item.get('gyration_m', (0, 0, 0)), float) ** 2)
        lump = Lump(size, np.array(item['position_m'], float), inertia)
        next(one for one in links if one.name == item['link']).lumps.append(lump)
    springs = (model.get('base') or {}).get('springs') or []
    damping = model.get('damping') or {}
    names = [link.joint.name for link in links if link.joint is not None]
    couple = np.eye(len(names))
    for item in model.get('coupling') or []:
        couple[names.index(item['axis']), names.index(item['added'])] += float(item['factor'])
    return Description(
        links,
        {way: Spring.of(item) for way, item in zip(BASE_WAYS, springs, strict=False)},
        couple,
        float(damping.get('mass_proportional_1_s', 0.0)),
    )


def _chain(tree, model):
    """Return the links from the base to the tip; the robots shipped are serial."""
    elements = {item.get('name'): item for item in tree.findall('link')}
    after = {item.find('parent').get('link'): item for item in tree.findall('joint')}
    children = {item.find('child').get('link') for item in after.values()}
    factors = {item['name']: item for item in model.get('links') or []}
    name = next(item for item in elements if item not in children)
    links = [Link(name, None, np.zeros(3), np.eye(3), _lumps(elements[name], factors))]
    while name in after:
        joint = after[name]
        name = joint.find('child').get('link')
        shift, turned = _origin(joint.find('origin'))
        axis = None if joint.get('type') == 'fixed' else _axis(joint, shift, turned, model)
        links.append(Link(name, axis, shift, turned, _lumps(elements[name], factors)))
    return links


def _axis(joint, shift, turned, model):
    data = (model.get('joints') or {}).get(joint.get('name')) or {}
    axis = _three(joint.find('axis').get('xyz'))
    return Axis(
        joint.get('name'),
        shift,
        turned,
        axis,
        Spring.of(data.get('drive') or {}),
        [Spring.of(item) for item in data.get('tilts') or []],
        float(data.get('gear_ratio', 1.0)),
        float(data.get('rotor_inertia_kg_m2', 0.0)),
    )


def across(axis):
    """Return the two axes a bearing tilts about, as model files count them."""
    first = np.eye(3)[(int(np.argmax(np.abs(axis))) + 1) % 3]
    return first, np.cross(axis, first)


def _lumps(element, factors):
    inertial = element.find('inertial')
    if inertial is None:
        return []
    known = factors.get(element.get('name'), {})
    com, turned = _origin(inertial.find('origin'))
    scale = float(known.get('mass_factor', 1.0))
    entries = {key: float(value) for key, value in inertial.find('inertia').items()}
    own = np.array([[entries[f'i{min(a, b)}{max(a, b)}'] for b in 'xyz'] for a in 'xyz'])
    own = turned @ own @ turned.T * scale * float(known.get('inertia_factor', 1.0))
    com = com + np.array(known.get('com_shift_m', (0, 0, 0)), float)
    return [Lump(float(inertial.find('mass').get('value')) * scale, com, own)]


def _origin(element):
    if element is None:
        return np.zeros(3), np.eye(3)
    turned = Rotation.from_euler('xyz', _three(element.get('rpy'))).as_matrix()
    return _three(element.get('xyz')), turned


def _three(text):
    return np.array([float(item) for item in (text or '0 0 0').split()])
