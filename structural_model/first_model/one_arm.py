"""One arm out of a URDF that has more: fingers, wheels and other arms stand still."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, tostring

from modal_core.errors import ModelError
from structural_model.description import read_urdf

STANDING = 'fixed'
DRAWN = ('cylinder', 'sphere', 'box')
KEPT = {
    'link': ('inertial', 'collision'),
    'joint': ('origin', 'parent', 'child', 'axis', 'limit'),
}
"""What a model needs of a URDF."""


@dataclass(frozen=True)
class OneArm:
    """A URDF in which only the joints of one arm move.

    Parameters
    ----------
    urdf : bytes
        The file; joints of no arm, and those that follow another one, stand at zero.
    joints : tuple of str
        Those that move, from the base on.
    standing : tuple of str
        Those that moved before.
    base, tip : str
        First and last link of the arm.
    """

    urdf: bytes
    joints: tuple[str, ...]
    standing: tuple[str, ...]
    base: str
    tip: str


def one_arm(text: bytes, where: str, tip: str | None = None) -> OneArm:
    """Return the arm of a URDF.

    Without a tip it goes from the root to where the moving joints branch or end: a hand's fingers
    branch, and belong to no arm.

    Parameters
    ----------
    text : bytes
        The URDF.
    where : str
        What to call it in errors.
    tip : str or None
        Last link.

    Raises
    ------
    ModelError
        Not a URDF, no such link, joints that branch at the root, no joint that moves, or one on
        the way that the model does not know.
    """
    root = read_urdf(text, where)
    joints = {_link(joint, 'child'): joint for joint in root.findall('joint')}
    links = [link.get('name', '') for link in root.findall('link')]
    (base,) = (name for name in links if name not in joints)
    if tip is None:
        tip = _end(base, joints, where)
    elif tip not in links:
        raise ModelError('unknown link', where=where, found=tip, expected=', '.join(links[:40]))
    way = _way(tip, joints)
    moving = tuple(
        joint.get('name', '') for joint in way if _moves(joint) and not _has_no_range(joint)
    )
    if not moving:
        raise ModelError('no moving joint', where=where, found=f'{base} to {tip}')
    standing = tuple(
        joint.get('name', '')
        for joint in root.findall('joint')
        if _moves(joint) and joint.get('name') not in moving
    )
    for joint in root.findall('joint'):
        if joint.get('name') not in moving:
            _stop(joint)
    _strip(root)
    return OneArm(tostring(root), moving, standing, base, tip)


def _end(base: str, joints: Mapping[str, Element], where: str) -> str:
    """Return the last link before the moving joints branch, or where they end."""
    below: dict[str, list[Element]] = {}
    for joint in joints.values():
        below.setdefault(_link(joint, 'parent'), []).append(joint)
    ahead = _joints_ahead(base, below)

    def reach(joint: Element) -> int:
        return _moves(joint) + ahead[_link(joint, 'child')]

    end, passed = base, 0
    while len(onward := [joint for joint in below.get(end, ()) if reach(joint)]) == 1:
        end, passed = _link(onward[0], 'child'), passed + _moves(onward[0])
    if onward and max(map(reach, onward)) >= passed:
        branches = ', '.join(_link(joint, 'child') for joint in onward[:8])
        raise ModelError(
            'several arms, or no arm',
            where=where,
            found=f'branches at {branches}',
            advice='name the last link of the arm as its tip',
        )
    # A tool's frame is fixed to the last body.
    while not onward and below.get(end):
        end = _link(below[end][-1], 'child')
    return end


def _joints_ahead(base: str, below: Mapping[str, Sequence[Element]]) -> dict[str, int]:
    """Return how many joints move on the longest way from each link on."""
    order = [base]
    for link in order:
        order += [_link(joint, 'child') for joint in below.get(link, ())]
    ahead: dict[str, int] = {}
    for link in reversed(order):
        ways = (_moves(joint) + ahead[_link(joint, 'child')] for joint in below.get(link, ()))
        ahead[link] = max(ways, default=0)
    return ahead


def _way(tip: str, joints: Mapping[str, Element]) -> Sequence[Element]:
    way = []
    while tip in joints:
        way.append(joints[tip])
        tip = _link(joints[tip], 'parent')
    return way[::-1]


def _moves(joint: Element) -> bool:
    return joint.get('type') != STANDING


def _has_no_range(joint: Element) -> bool:
    limit = joint.find('limit')
    ends = () if limit is None else (limit.get('lower', '0'), limit.get('upper', '0'))
    return joint.get('type') in ('revolute', 'prismatic') and len(set(ends)) == 1


def _stop(joint: Element) -> None:
    joint.set('type', STANDING)
    for part in ('axis', 'limit', 'mimic'):
        for element in joint.findall(part):
            joint.remove(element)


def _strip(root: Element) -> None:
    """Leave out pictures, drives and meshes, which no model reads."""
    for element in list(root):
        if element.tag not in KEPT:
            root.remove(element)
            continue
        for part in list(element):
            drawn = any(part.find(f'geometry/{kind}') is not None for kind in DRAWN)
            if part.tag not in KEPT[element.tag] or (part.tag == 'collision' and not drawn):
                element.remove(part)


def _link(joint: Element, role: str) -> str:
    element = joint.find(role)
    return '' if element is None else element.get('link', '')
