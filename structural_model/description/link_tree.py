"""The tree of a URDF's links: what moves beyond each, and their order from the base to the tip."""

from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

STANDING = 'fixed'


def link_of(joint: Element, role: str) -> str:
    """Return the parent or child of a joint, empty where it names none."""
    element = joint.find(role)
    return '' if element is None else element.get('link', '')


def moves(joint: Element) -> bool:
    """Return whether a joint is not fixed."""
    return joint.get('type') != STANDING


def joints_below(root: Element) -> dict[str, list[Element]]:
    """Return the joints that hang on each link, in the order of the file."""
    below: dict[str, list[Element]] = {}
    for joint in root.findall('joint'):
        below.setdefault(link_of(joint, 'parent'), []).append(joint)
    return below


def base_of(root: Element) -> str:
    """Return the link that hangs on no joint, of a URDF that is one tree."""
    children = {link_of(joint, 'child') for joint in root.findall('joint')}
    return next(
        name for link in root.findall('link') if (name := link.get('name', '')) not in children
    )


def joints_ahead(base: str, below: Mapping[str, Sequence[Element]]) -> dict[str, int]:
    """Return how many joints move on the longest way from each link on."""
    order = [base]
    for link in order:
        order += [link_of(joint, 'child') for joint in below.get(link, ())]
    ahead: dict[str, int] = {}
    for link in reversed(order):
        ways = (moves(joint) + ahead[link_of(joint, 'child')] for joint in below.get(link, ()))
        ahead[link] = max(ways, default=0)
    return ahead


def links_in_order(root: Element) -> tuple[str, ...]:
    """Return all links, the base first and the tip of the longest chain last.

    Files name them in any order; what hangs beside the chain comes before what goes on.
    """
    base, below = base_of(root), joints_below(root)
    ahead = joints_ahead(base, below)

    def reach(joint: Element) -> int:
        return moves(joint) + ahead[link_of(joint, 'child')]

    order, waiting = [], [base]
    while waiting:
        order.append(waiting.pop())
        onward = sorted(below.get(order[-1], ()), key=reach)
        waiting += [link_of(joint, 'child') for joint in reversed(onward)]
    return tuple(order)
