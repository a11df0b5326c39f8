"""The tree of a URDF's links: what moves beyond each, and their order from the base to the tip."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self
from xml.etree.ElementTree import Element

STANDING = 'fixed'


def link_of(joint: Element, role: str) -> str:
    """Return the parent or child of a joint, empty where it names none."""
    element = joint.find(role)
    return '' if element is None else element.get('link', '')


def moves(joint: Element) -> bool:
    """Return whether a joint is not fixed."""
    return joint.get('type') != STANDING


@dataclass(frozen=True)
class LinkTree:
    """Links and the joints that hang on them.

    Parameters
    ----------
    base : str
        The link that hangs on no joint.
    above : dict of str to Element
        The joint that each other link hangs on.
    below : dict of str to sequence of Element
        Joints that hang on each link, in the order of the file.
    ahead : dict of str to int
        How many joints move on the longest way from each link on.
    """

    base: str
    above: Mapping[str, Element]
    below: Mapping[str, Sequence[Element]]
    ahead: Mapping[str, int]

    @classmethod
    def of(cls, root: Element) -> Self:
        """Return that of a URDF that is one tree."""
        below: dict[str, list[Element]] = {}
        for joint in root.findall('joint'):
            below.setdefault(link_of(joint, 'parent'), []).append(joint)
        above = {link_of(joint, 'child'): joint for joint in root.findall('joint')}
        names = (link.get('name', '') for link in root.findall('link'))
        base = next(name for name in names if name not in above)
        order = [base]
        for link in order:
            order += [link_of(joint, 'child') for joint in below.get(link, ())]
        ahead: dict[str, int] = {}
        for link in reversed(order):
            ways = (moves(joint) + ahead[link_of(joint, 'child')] for joint in below.get(link, ()))
            ahead[link] = max(ways, default=0)
        return cls(base, above, below, ahead)

    def way_to(self, tip: str) -> tuple[Element, ...]:
        """Return the joints from the base to a link."""
        way = []
        while tip in self.above:
            way.append(self.above[tip])
            tip = link_of(way[-1], 'parent')
        return tuple(way[::-1])

    def reach(self, joint: Element) -> int:
        """Return how many joints move from a joint on, itself among them."""
        return moves(joint) + self.ahead[link_of(joint, 'child')]

    def in_order(self) -> tuple[str, ...]:
        """Return all links, the base first and the tip of the longest chain last.

        Files name them in any order; what hangs beside the chain comes before what goes on.
        """
        order, waiting = [], [self.base]
        while waiting:
            order.append(waiting.pop())
            onward = sorted(self.below.get(order[-1], ()), key=self.reach)
            waiting += [link_of(joint, 'child') for joint in reversed(onward)]
        return tuple(order)
