"""Which topics are of the identifier's own cell, where several cells share one ROS domain."""

from collections.abc import Iterable

# Only nodes of a cell publish these: where one is, there is a cell.
CELL_TYPES = frozenset(
    ('oma_msgs/msg/BridgeState', 'oma_msgs/msg/ExcitationPlan', 'oma_msgs/msg/ModalParameters')
)


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
