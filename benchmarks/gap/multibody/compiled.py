"""An arm as a MuJoCo model: bodies, passive hinges and slides, sensors, springs between points.

Every drive is a hinge that a law twists; what tilts, slides or bends is a hinge or slide with a
spring and a damper of its own, in series with it.
"""

from dataclasses import dataclass
import math
import xml.etree.ElementTree as ET

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.gap.multibody.description import across

G = 9.81
EYE = np.eye(3)


@dataclass
class Sensor:
    """An accelerometer with three axes: its link, place and how it is turned there."""

    name: str
    link: str
    at: np.ndarray
    turned: np.ndarray


@dataclass
class Compiled:
    """The engine's model.

    ``drives`` are the numbers of the driven joints, ``pulls`` those of the springs between points
    that are tied anew in every pose, with how they pull there [N].
    """

    model: mujoco.MjModel
    drives: np.ndarray
    couple: np.ndarray
    k: np.ndarray
    c: np.ndarray
    mass_damping: float
    ratios: np.ndarray
    rotors: np.ndarray
    pulls: dict


def compiled(arm, sensors):
    """Return the engine's model of a description with these sensors."""
    root = ET.Element('mujoco')
    ET.SubElement(root, 'compiler', angle='radian')
    option = ET.SubElement(root, 'option', gravity=f'0 0 {-G}')
    ET.SubElement(option, 'flag', constraint='disable')
    world = ET.SubElement(root, 'worldbody')
    bodies = _bodies(world, arm)
    for item in arm.swinging:
        _swinging(bodies[item['link']], arm, item)
    for item in sensors:
        place = _beyond(arm, item.link, item.at)
        ET.SubElement(bodies[item.link], 'site', name=item.name, **_placed(place, item.turned))
    _tendons(root, world, bodies, arm)
    readings = ET.SubElement(root, 'sensor')
    for item in sensors:
        ET.SubElement(readings, 'accelerometer', site=item.name)
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding='unicode'))
    axes = arm.axes
    return Compiled(
        model,
        np.array([int(model.joint(axis.name).dofadr[0]) for axis in axes]),
        arm.couple,
        np.array([axis.drive.k for axis in axes]),
        np.array([axis.drive.c for axis in axes]),
        arm.mass_damping,
        np.array([axis.ratio for axis in axes]),
        np.array([axis.rotor * axis.ratio**2 for axis in axes]),
        {number: item['pull'] for number, item in enumerate(arm.tendons) if 'pull' in item},
    )


def _bodies(world, arm):
    """Add floor, links and what is fixed to them; return where things on each link belong."""
    parent, found = world, {}
    for number, item in enumerate(arm.below):
        parent = ET.SubElement(parent, 'body', name=f'below_{number}')
        inertia = item['mass'] * item['gyration'] ** 2 * EYE
        _inertial(parent, item['mass'], np.zeros(3), inertia)
        _springs(parent, f'below_{number}', item['ways'], (0.0, 0.0, item.get('height', 0.0)))
    for link in arm.links:
        shift = link.shift
        if found:
            before = list(found)[-1]
            shift = _beyond(arm, before, shift)
        parent = ET.SubElement(parent, 'body', name=link.name, **_placed(shift, link.turned))
        if not found:
            _springs(parent, 'base', arm.base)
        if link.joint is not None:
            _axis(parent, link.joint)
        parent = found[link.name] = _contents(parent, arm, link)
    return found


def _axis(body, joint):
    """Add the tilts of a bearing that give way, then the drive."""
    for number, (axis, spring) in enumerate(zip(across(joint.axis), joint.tilts, strict=False), 1):
        _passive(body, f'{joint.name}/tilt_{number}', 'hinge', axis, spring)
    ET.SubElement(body, 'joint', name=joint.name, type='hinge', axis=_text(joint.axis))


def _springs(body, name, ways, at=(0.0, 0.0, 0.0)):
    for way, spring in ways.items():
        kind, axis = ('slide' if way[0] == 't' else 'hinge'), EYE['xyz'.index(way[1])]
        _passive(body, f'{name}/{way}', kind, axis, spring, at)


def _passive(body, name, kind, axis, spring, at=(0.0, 0.0, 0.0)):
    if math.isfinite(spring.k):
        ET.SubElement(
            body,
            'joint',
            name=name,
            type=kind,
            axis=_text(axis),
            pos=_text(at),
            stiffness=repr(float(spring.k)),
            damping=repr(float(spring.c)),
        )


def _contents(body, arm, link):
    """Add the link's mass, on both sides of a hinge where it bends; return its outer part."""
    hinge = arm.hinge if arm.hinge and arm.hinge['link'] == link.name else None
    near = 1.0 if hinge is None else hinge['near']
    _lumps(body, link.lumps, near, np.zeros(3))
    if hinge is None:
        return body
    outer = ET.SubElement(body, 'body', name=f'{link.name}/outer', pos=_text(hinge['at']))
    _passive(outer, 'hinge', 'hinge', hinge['axis'], hinge['spring'])
    _lumps(outer, link.lumps, 1.0 - near, np.asarray(hinge['at'], float))
    return outer


def _lumps(body, lumps, share, origin):
    """Sum lumps up: one body has one inertia."""
    if not lumps:
        return
    mass = sum(item.mass for item in lumps)
    com = sum(item.mass * item.com for item in lumps) / mass
    inertia = sum(item.inertia + item.mass * _steiner(item.com - com) for item in lumps)
    _inertial(body, share * mass, com - origin, share * inertia)


def _steiner(r):
    return r @ r * EYE - np.outer(r, r)


def _inertial(body, mass, com, inertia):
    """Add a body's inertia by its principal axes."""
    size, axes = np.linalg.eigh(0.5 * (inertia + inertia.T))
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    size = np.maximum(size, 1e-9)
    ET.SubElement(
        body,
        'inertial',
        mass=repr(float(mass)),
        diaginertia=_text(size),
        **_placed(com, axes),
    )


def _swinging(body, arm, item):
    """Add a mass on a slide, a spring and a damper."""
    place = _beyond(arm, item['link'], item['at'])
    swing = ET.SubElement(body, 'body', name=f'swinging_{item["link"]}', pos=_text(place))
    omega = 2.0 * math.pi * item['f']
    ET.SubElement(
        swing,
        'joint',
        name=f'swinging_{item["link"]}',
        type='slide',
        axis=_text(item['axis']),
        stiffness=repr(float(item['mass'] * omega**2)),
        damping=repr(float(2.0 * item['zeta'] * item['mass'] * omega)),
    )
    _inertial(swing, item['mass'], np.zeros(3), 1e-6 * item['mass'] * EYE)


def _tendons(root, world, bodies, arm):
    """Add springs between two points (a link's, or the ground's)."""
    tendons = ET.SubElement(root, 'tendon')
    for number, item in enumerate(arm.tendons):
        attributes = {'stiffness': repr(float(item['k']))}
        if 'length' in item:
            attributes['springlength'] = repr(float(item['length']))
        spatial = ET.SubElement(tendons, 'spatial', **attributes)
        for end in ('from', 'to'):
            link, at = item[end]
            name = f'tendon_{number}_{end}'
            holder = world if link is None else bodies[link]
            place = np.asarray(at, float) if link is None else _beyond(arm, link, at)
            ET.SubElement(holder, 'site', name=name, pos=_text(place))
            ET.SubElement(spatial, 'site', site=name)


def _beyond(arm, link, at):
    """Return a place on a link as its outer part sees it."""
    hinge = arm.hinge
    at = np.asarray(at, float)
    return at - np.asarray(hinge['at'], float) if hinge and hinge['link'] == link else at


def _placed(shift, turned):
    x, y, z, w = Rotation.from_matrix(turned).as_quat()
    return {'pos': _text(shift), 'quat': _text((w, x, y, z))}


def _text(values):
    return ' '.join(repr(float(value)) for value in values)
