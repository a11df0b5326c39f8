"""Which topics are of the identifier's own cell, where several cells share one ROS domain."""

from collections.abc import Iterable, Sequence
from typing import Any, Protocol

# Only nodes of a cell publish these: where one is, there is a cell.
CELL_TYPES = frozenset(
    ('oma_msgs/msg/BridgeState', 'oma_msgs/msg/ExcitationPlan', 'oma_msgs/msg/ModalParameters')
)
# What the graph says of a publisher before it has heard of its node.
NOT_YET_KNOWN = '_NODE_NAMESPACE_UNKNOWN_'


class Graph(Protocol):
    """What a node knows of the others."""

    def get_publishers_info_by_topic(self, topic_name: str) -> Iterable[Any]:
        """Return a topic's publishers."""


def cells(graph: Graph, topics: Sequence[tuple[str, Sequence[str]]]) -> set[str] | None:
    """Return the namespaces of all nodes that are part of a cell; None while one is not known.

    Parameters
    ----------
    graph : Graph
        The node that asks.
    topics : sequence of (name, types)
        All topics it knows.
    """
    found = {
        publisher.node_namespace
        for topic, types in topics
        if CELL_TYPES.intersection(types)
        for publisher in graph.get_publishers_info_by_topic(topic)
    }
    return None if NOT_YET_KNOWN in found else found


def is_of_cell(topic: str, namespace: str, others: Iterable[str]) -> bool:
    """Return whether a topic lies in a namespace, and in no other cell's within it.

    Parameters
    ----------
    topic : str
        Full name.
    namespace : str
        Of the identifier; ``/`` holds everything that is no other cell's.
    others : iterable of str
        Namespaces of the nodes of other cells.
    """
    if not _lies_in(topic, namespace):
        return False
    return not any(
        _lies_in(topic, other)
        for other in others
        if other != namespace and _lies_in(other, namespace)
    )


def _lies_in(name: str, namespace: str) -> bool:
    return name.startswith(f'{namespace.rstrip("/")}/')
