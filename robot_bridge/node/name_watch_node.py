"""Whether another node offers what a bridge offers: then one request would reach two arms."""

import threading
import time

from rclpy.callback_groups import CallbackGroup
from rclpy.duration import Duration
from rclpy.event_handler import QoSLivelinessChangedInfo, SubscriptionEventCallbacks
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

from oma_msgs.msg import BridgeState

# Participants announce themselves five times within the first half second and then every three
# seconds (Fast DDS defaults): two rounds of the slow kind may be lost before one is missed.
DISCOVERY_S = 3.5
# A bridge that has told no state for so long counts as dead.  Shorter would gain nothing: who
# comes after it has to look around for DISCOVERY_S first.
LEASE_S = 3.0
# Before others may believe that, a bridge that stood still (a stopped process, a machine without
# time) takes itself for dead; the difference covers what a state takes to arrive.
LONGEST_SILENCE_S = 2.0
# The last state, also for those who come late; each is a sign of life.
STATE_QOS = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
    liveliness_lease_duration=Duration(seconds=LEASE_S),
)
SERVICES = ('arm', 'start', 'abort', 'reset')


class NameWatch:
    """Looks for others in the ROS graph, as far as it is known by now.

    A bridge that was killed stays in the graph for up to 20 s, the lease of its DDS participant.
    Its states end at once: whoever's sign of life is overdue does not count.  A node that offers
    the names of a bridge and promises no sign of life counts as long as it is in the graph.

    Parameters
    ----------
    node : LifecycleNode
        The one that should be alone with its names.
    group : CallbackGroup
        Of the signs of life of others.
    """

    def __init__(self, node: LifecycleNode, group: CallbackGroup) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._began_s = _now_s()
        self._told_s: float | None = None
        self._stood_still = False
        self._n_alive = self._n_dead = 0
        node.create_subscription(
            BridgeState,
            '~/state',
            lambda _: None,
            STATE_QOS,
            callback_group=group,
            event_callbacks=SubscriptionEventCallbacks(liveliness=self._on_liveliness),
            raw=True,
        )

    @property
    def settled(self) -> bool:
        """Whether there was time to discover everybody."""
        return _now_s() - self._began_s >= DISCOVERY_S

    def settle(self) -> None:
        """Wait until there was."""
        time.sleep(max(0.0, self._began_s + DISCOVERY_S - _now_s()))

    def tell(self) -> None:
        """Note that a state is published now: a sign of life."""
        with self._lock:
            self._note_silence()
            self._told_s = _now_s()

    def others(self) -> str:
        """Return what another node offers as well, empty when this one is alone."""
        with self._lock:
            self._note_silence()
            if self._stood_still:
                return (
                    'this bridge stood still and another may have taken its place:'
                    f' it looks around for {DISCOVERY_S:g} s'
                )
        node = self._node
        own = (node.get_name(), node.get_namespace())
        n_states = node.count_publishers('~/state')
        most = 1 + min(self._n_dead, max(0, n_states - self._n_alive))
        found = []
        if node.get_node_names_and_namespaces().count(own) > most:
            found.append('its name')
        if n_states > most:
            found.append('its state')
        found += [f'~/{name}' for name in SERVICES if node.count_services(f'~/{name}') > most]
        if not found:
            return ''
        return f'another node offers {", ".join(found)} of {node.get_fully_qualified_name()}'

    def _note_silence(self) -> None:
        """Look around anew where others may have taken this one for dead."""
        told_s = self._told_s
        if told_s is not None and _now_s() - told_s > LONGEST_SILENCE_S:
            self._began_s, self._stood_still = _now_s(), True
        elif self.settled:
            self._stood_still = False

    def _on_liveliness(self, status: QoSLivelinessChangedInfo) -> None:
        self._n_alive, self._n_dead = status.alive_count, status.not_alive_count


def _now_s() -> float:
    """Return a time that also runs while the machine sleeps, where there is one [s]."""
    return time.clock_gettime(getattr(time, 'CLOCK_BOOTTIME', time.CLOCK_MONOTONIC))
