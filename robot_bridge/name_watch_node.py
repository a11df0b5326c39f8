"""Whether another node offers what a bridge offers: then one request would reach two arms."""

import time

from rclpy.lifecycle import LifecycleNode

# Participants announce themselves five times within the first half second and then every three
# seconds (Fast DDS defaults): two rounds of the slow kind may be lost before one is missed.
DISCOVERY_S = 3.5
SERVICES = ('arm', 'start', 'abort', 'reset')


class NameWatch:
    """Looks for others in the ROS graph, as far as it is known by now.

    A bridge that was killed stays in the graph until its lease runs out, 20 s by default: it
    cannot be told from one that only stands still, and counts as there.

    Parameters
    ----------
    node : LifecycleNode
        The one that should be alone with its names.
    """

    def __init__(self, node: LifecycleNode) -> None:
        self._node = node
        self._began_s = time.monotonic()

    @property
    def settled(self) -> bool:
        """Whether there was time to discover everybody."""
        return time.monotonic() - self._began_s >= DISCOVERY_S

    def settle(self) -> None:
        """Wait until there was."""
        time.sleep(max(0.0, self._began_s + DISCOVERY_S - time.monotonic()))

    def others(self) -> str:
        """Return what another node offers as well, empty when this one is alone."""
        node = self._node
        own = (node.get_name(), node.get_namespace())
        found = []
        if node.get_node_names_and_namespaces().count(own) > 1:
            found.append('its name')
        if node.count_publishers('~/state') > 1:
            found.append('its state')
        found += [f'~/{name}' for name in SERVICES if node.count_services(f'~/{name}') > 1]
        if not found:
            return ''
        return f'another node offers {", ".join(found)} of {node.get_fully_qualified_name()}'
