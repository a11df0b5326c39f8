"""Starts the identifier node in this process and talks to it over real Fast DDS."""

import threading
import time

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from oma_identifier.node.identifier_node import IdentifierNode
from oma_identifier.node.ros_messages import MESSAGE_CLASSES
from oma_msgs.msg import ModalParameters

LATCHED = QoSProfile(
    depth=100,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


class NodeDriver:
    """An identifier node on its own thread, and a peer node that sends and listens."""

    def __init__(self, context, **parameters):
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        self.node = IdentifierNode(context=context, parameter_overrides=overrides)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.thread = threading.Thread(target=self._spin, daemon=True)
        self.running = True
        self.peer = rclpy.create_node('peer', context=context)
        self.peer_executor = SingleThreadedExecutor(context=context)
        self.peer_executor.add_node(self.peer)
        self.results = []
        self.peer.create_subscription(
            ModalParameters, '/oma_identifier/modal_parameters', self.results.append, LATCHED
        )
        self.publishers = {}
        self.thread.start()

    def _spin(self):
        while self.running:
            self.executor.spin_once(timeout_sec=0.1)

    def publisher(self, topic, message_type, reliability=ReliabilityPolicy.RELIABLE):
        """Return a publisher the identifier has found."""
        if topic not in self.publishers:
            profile = QoSProfile(depth=20000, reliability=reliability)
            publisher = self.peer.create_publisher(MESSAGE_CLASSES[message_type], topic, profile)
            deadline = time.monotonic() + 20.0
            while publisher.get_subscription_count() == 0:
                assert time.monotonic() < deadline, f'nobody listens to {topic}'
                time.sleep(0.02)
            self.publishers[topic] = publisher
        return self.publishers[topic]

    def send(self, messages, *, pause_every=50, in_step=True):
        """Send serialised messages, in log order, as quickly as the node takes them.

        Out of step it only takes them; a window that comes while others wait is skipped then.
        """
        messages = list(messages)
        for topic, message_type in dict.fromkeys((m.topic, m.message_type) for m in messages):
            self.publisher(topic, message_type)
        for number, message in enumerate(messages):
            self.publishers[message.topic].publish(message.data)
            if number % pause_every == pause_every - 1:
                self.wait_for(number)
                if in_step:
                    self.wait_identified()

    def n_received(self):
        """Messages the node has taken."""
        return sum(self.node.intake.n_messages.values())

    def wait_for(self, n_sent, timeout_s=30.0):
        """Wait until the node is not far behind."""
        deadline = time.monotonic() + timeout_s
        while self.n_received() < n_sent - 150 and time.monotonic() < deadline:
            time.sleep(0.005)

    def wait_identified(self, timeout_s=90.0):
        """Wait until no window waits for the one that is identified."""
        deadline = time.monotonic() + timeout_s
        while self.node.worker.n_waiting and time.monotonic() < deadline:
            time.sleep(0.005)

    def wait_received(self, count, timeout_s=30.0):
        """Wait until the node has taken this many messages."""
        deadline = time.monotonic() + timeout_s
        while self.n_received() < count and time.monotonic() < deadline:
            time.sleep(0.01)

    def finish(self):
        """Flush the node and collect its results."""
        client = self.peer.create_client(Trigger, '/oma_identifier/finish')
        assert client.wait_for_service(10.0)
        future = client.call_async(Trigger.Request())
        self.peer_executor.spin_until_future_complete(future, timeout_sec=90.0)
        answer = future.result()
        assert answer is not None and answer.success
        deadline = time.monotonic() + 30.0
        while len(self.results) < self.node.worker.n_done and time.monotonic() < deadline:
            self.peer_executor.spin_once(timeout_sec=0.05)
        self.collect()
        return answer

    def collect(self, seconds=0.5):
        """Take in what has been published."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self.peer_executor.spin_once(timeout_sec=0.05)

    def close(self):
        """Stop everything."""
        self.running = False
        self.thread.join(5.0)
        self.node.destroy_node()
        self.peer.destroy_node()


def three_modes(duration_s, rate_hz, n_channels, seed):
    """Return accelerations of three modes under white noise, by exact discretisation."""
    from scipy.signal import cont2discrete, dlsim

    frequencies, damping = np.array([7.0, 12.0, 19.0]), np.array([0.02, 0.015, 0.02])
    rng = np.random.default_rng(seed)
    n = int(duration_s * rate_hz)
    shapes = rng.normal(size=(n_channels, 3))
    total = np.zeros((n, n_channels))
    for column, (f, z) in enumerate(zip(frequencies, damping, strict=True)):
        w = 2 * np.pi * f
        a = np.array([[0, 1], [-w * w, -2 * z * w]])
        system = cont2discrete(
            (a, np.array([[0], [1.0]]), np.array([[-w * w, -2 * z * w]]), np.array([[0.0]])),
            1 / rate_hz,
        )
        _, response, _ = dlsim(system, rng.normal(size=n))
        total += response / response.std() @ shapes[:, column : column + 1].T
    return total + 0.05 * rng.normal(size=total.shape), frequencies
