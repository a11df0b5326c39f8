"""The operator of the node tests: a node that arms, starts and holds to run, and remembers."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time

from diagnostic_msgs.msg import DiagnosticArray
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from modal_core.files.share import share_path
from oma_msgs.msg import BridgeState, ExcitationPlan, Heartbeat
from oma_msgs.srv import ArmPlan, StartPlan

LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
HEARTBEAT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=5000, reliability=ReliabilityPolicy.RELIABLE)
MODULES = {
    'robot_bridge': 'robot_bridge.node.bridge_node',
    'abb_emulator': 'abb_emulator.node.emulator_node',
    'replay': 'robot_bridge.node.replay_node',
    'trajectory_controller': 'test.support.trajectory_controller',
}
FILES = {'robot_bridge': 'bridge.yaml', 'abb_emulator': 'emulator.yaml'}


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


def spell(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, (list, tuple)):
        return f'[{", ".join(spell(item) for item in value)}]'
    return str(value)


class NodeProcess:
    """One node as a process."""

    def __init__(self, name, domain, limits=None, namespace='', **parameters):
        self.name, self.parameters, self.said = name, parameters, None
        line = [sys.executable, '-m', MODULES[name], '--ros-args']
        if name in FILES:
            line += ['--params-file', str(share_path('config') / FILES[name])]
        if namespace:
            line += ['-r', f'__ns:={namespace}']
        for key, value in parameters.items():
            line += ['-p', f'{key.replace("__", ".")}:={spell(value)}']

        def before():
            # A shell without job control starts processes that ignore interrupts.
            signal.signal(signal.SIGINT, signal.default_int_handler)
            if limits is not None:
                limits()

        self.process = subprocess.Popen(
            line,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            env={**os.environ, 'ROS_DOMAIN_ID': str(domain)},
            text=True,
            preexec_fn=before,
        )

    def kill(self):
        self.process.kill()
        self.said = self.process.communicate()[1]

    def stop(self):
        """Stop it as Ctrl-C does and return what it said on its error channel."""
        if self.said is not None:
            return self.said
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            self.said = self.process.communicate(timeout=30.0)[1]
        except subprocess.TimeoutExpired:
            self.kill()
            raise
        return self.said


class Operator:
    """Arms, starts, holds to run; remembers every state and joint position."""

    def __init__(self, context):
        self.node = Node('operator', context=context)
        self.states, self.joints, self.diagnostics = [], [], []
        self.holding, self.released_s, self.token = False, None, ''
        create = self.node.create_subscription
        create(BridgeState, '/robot_bridge/state', self.states.append, RELIABLE)
        create(JointState, '/joint_states', self.joints.append, RELIABLE)
        create(DiagnosticArray, '/diagnostics', self.diagnostics.append, RELIABLE)
        self.plans = self.node.create_publisher(
            ExcitationPlan, '/excitation_planner/excitation_plan', LATCHED
        )
        self.beats = self.node.create_publisher(Heartbeat, '/robot_bridge/heartbeat', HEARTBEAT)
        self._clients = {}
        self._closing = threading.Event()
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self._threads = [
            threading.Thread(target=target, daemon=True) for target in (self._spin, self._beat)
        ]
        for thread in self._threads:
            thread.start()

    def _spin(self):
        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()

    def _beat(self):
        while not self._closing.wait(0.02):
            if self.holding:
                self.released_s = time.monotonic()
                self.beats.publish(Heartbeat(token=self.token))

    def close(self):
        self._closing.set()
        self._executor.shutdown()
        for thread in self._threads:
            thread.join()
        self.node.destroy_node()

    # -- asking --------------------------------------------------------------------------------

    def client(self, service, kind):
        if (service, kind) not in self._clients:
            self._clients[service, kind] = self.node.create_client(kind, service)
        return self._clients[service, kind]

    def call(self, service, kind=Trigger, patience_s=30.0, **fields):
        client = self.client(service, kind)
        assert client.wait_for_service(patience_s), f'no service {service}'
        future = client.call_async(kind.Request(**fields))
        self.until(future.done, f'answer of {service}', patience_s)
        return future.result()

    def arm(self, plan_hash, timeout_s=30.0, controller=None):
        """Release a plan for the controller the state names; with the token it answers, hold."""
        if controller is None:
            controller = self.last.controller if self.last is not None else ''
        answer = self.call(
            '/robot_bridge/arm',
            ArmPlan,
            plan_hash=plan_hash,
            controller=controller,
            timeout_s=timeout_s,
        )
        self.token = answer.token or self.token
        if self.holding:
            time.sleep(0.1)
        return answer

    def arm_later(self, plan_hash, controller):
        """Ask for a release without waiting for the answer; return its future."""
        client = self.client('/robot_bridge/arm', ArmPlan)
        return client.call_async(
            ArmPlan.Request(plan_hash=plan_hash, controller=controller, timeout_s=30.0)
        )

    def start(self):
        return self.call('/robot_bridge/start', StartPlan, token=self.token)

    def abort(self):
        return self.call('/robot_bridge/abort')

    def reset(self):
        return self.call('/robot_bridge/reset')

    def hold(self, holding=True):
        self.holding = holding
        if holding:
            time.sleep(0.1)
        return self

    # -- waiting -------------------------------------------------------------------------------

    def until(self, condition, what='', patience_s=40.0, pause_s=0.01):
        deadline = time.monotonic() + patience_s
        while not condition():
            assert time.monotonic() < deadline, f'{what}; last state {self.last!r}'
            time.sleep(pause_s)

    @property
    def last(self):
        return self.states[-1] if self.states else None

    def until_state(self, state, patience_s=40.0, **fields):
        """Wait for a state that is published from now on; return it."""
        seen = len(self.states)

        def there():
            return any(
                item.state == state
                and all(getattr(item, name) == value for name, value in fields.items())
                for item in self.states[seen:]
            )

        self.until(there, f'state {state} {fields}', patience_s)
        return self.last

    def until_connected(self):
        self.until(lambda: self.last is not None and self.last.connected, 'connection')

    def offer(self, message):
        """Publish a plan and wait until the bridge has it in hand."""
        self.plans.publish(message)
        self.until(
            lambda: self.last is not None and self.last.plan_hash == message.plan_hash, 'plan'
        )

    def codes(self, name):
        """Return the diagnostic messages of a node so far."""
        return [
            status.message
            for array in self.diagnostics
            for status in array.status
            if name in status.name
        ]


def context_of(domain):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    return context
