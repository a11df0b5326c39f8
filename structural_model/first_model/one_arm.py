"""One arm out of a URDF that has more: fingers, wheels and other arms stand still."""

from dataclasses import dataclass
from xml.etree.ElementTree import Element, tostring

from modal_core.errors import ModelError
from structural_model.description import (
    keep_only,
    link_of,
    LinkTree,
    moves,
    NEEDED,
    read_urdf,
    STANDING,
)

DRAWN = ('cylinder', 'sphere', 'box')
KEPT = {'link': (*NEEDED['link'], 'collision'), 'joint': (*NEEDED['joint'], 'mimic')}
"""What a model needs of a URDF, and what it has to refuse: an axis that follows another one."""


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
    tree = LinkTree.of(root)
    links = tree.in_order()
    if tip is None:
        tip = _end(tree, where)
    elif tip not in links:
        raise ModelError('unknown link', where=where, found=tip, expected=', '.join(links[:40]))
    moving = tuple(
        joint.get('name', '')
        for joint in tree.way_to(tip)
        if moves(joint) and not _has_no_range(joint)
    )
    if not moving:
        raise ModelError('no moving joint', where=where, found=f'{tree.base} to {tip}')
    standing = tuple(
        joint.get('name', '')
        for joint in root.findall('joint')
        if moves(joint) and joint.get('name') not in moving
    )
    for joint in root.findall('joint'):
        if joint.get('name') not in moving:
            _stop(joint)
    _strip(root)
    return OneArm(tostring(root), moving, standing, tree.base, tip)


def _end(tree: LinkTree, where: str) -> str:
    """Return the last link before the moving joints branch, or where they end."""
    end, passed = tree.base, 0
    while len(onward := [joint for joint in tree.below.get(end, ()) if tree.reach(joint)]) == 1:
        end, passed = link_of(onward[0], 'child'), passed + moves(onward[0])
    if onward and max(map(tree.reach, onward)) >= passed:
        branches = ', '.join(link_of(joint, 'child') for joint in onward[:8])
        raise ModelError(
            'several arms, or no arm',
            where=where,
            found=f'branches at {branches}',
            advice='name the last link of the arm as its tip',
        )
    # A tool's frame is fixed to the last body.
    while not onward and tree.below.get(end):
        end = link_of(tree.below[end][-1], 'child')
    return end


def _has_no_range(joint: Element) -> bool:
    limit = joint.find('limit')
    if limit is None or joint.get('type') not in ('revolute', 'prismatic'):
        return False
    try:
        low, high = (float(limit.get(end, '0')) for end in ('lower', 'upper'))
    except ValueError:
        return False  # refused by name, where limits are read
    return low == high


def _stop(joint: Element) -> None:
    joint.set('type', STANDING)
    for part in ('axis', 'limit', 'mimic'):
        for element in joint.findall(part):
            joint.remove(element)


def _strip(root: Element) -> None:
    """Leave out pictures, drives and meshes, which no model reads."""
    keep_only(root, KEPT)
    for link in root.findall('link'):
        for part in link.findall('collision'):
            if all(part.find(f'geometry/{kind}') is None for kind in DRAWN):
                link.remove(part)
