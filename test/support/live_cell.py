"""What a cell tells its page, over real topics: results of a robot's own modes with scatter."""

from contextlib import contextmanager
import threading
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter

import autonomous_modal_analysis as ama
from modal_core.mode import Mode, ModeSet
from modal_core.nodes.ros_messages import diagnostic, LATCHED
from modal_core.poles import PoleStatus, PoleTable
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.window import Pose
from modal_dashboard.dashboard_node import DashboardNode
from oma_identifier.node.ros_messages import modal_parameters, stabilisation_diagram
from oma_identifier.result import WindowResult
from oma_identifier.spectra import SingularValueSpectrum
from oma_msgs.msg import BridgeState, ExcitationPlan, ModalParameters, StabilisationDiagram
from test.support.domains import ros_domain

ROBOT = 'irb6660_205_190'
START_NS = 1_780_000_000 * 10**9
WINDOW_NS = 24 * 10**9
HIGHEST_HZ = 60.0
PUBLISHED = (
    ('results', ModalParameters, 'oma_identifier/modal_parameters'),
    ('diagrams', StabilisationDiagram, 'oma_identifier/stabilisation_diagram'),
    ('bridge', BridgeState, 'robot_bridge/state'),
    ('plans', ExcitationPlan, 'excitation_planner/excitation_plan'),
)


class Results:
    """Windows of a robot: its true modes, each estimate with the scatter its σ says."""

    def __init__(self, seed=20, rename=None):
        self.rng = np.random.default_rng(seed)
        found = ama.model(ROBOT, pose_deg=[0, 45, -10, 90, -90, 0])
        inside = np.asarray(found.frequencies_hz) < HIGHEST_HZ
        self.frequency_hz = np.asarray(found.frequencies_hz)[inside]
        self.shapes = np.asarray(found.shapes)[:, inside]
        rename = rename or (lambda name: name)
        self.names = tuple(rename(name) for name in found.channel_names)
        self.pose = Pose(tuple(found.model.joint_names), found.q, np.zeros(len(found.q)))
        self.index = 0

    def next(self, **changes):
        """Return the next window."""
        modes = [self._mode(number) for number in range(len(self.frequency_hz))]
        start_ns = START_NS + self.index * WINDOW_NS
        line = Mode(49.98, 0.0, self.shapes[:, 0], 0.002, harmonic=True)
        values = {
            'index': self.index,
            'start_ns': start_ns,
            'end_ns': start_ns + WINDOW_NS,
            'modes': ModeSet(tuple(modes), self.names),
            'harmonics': ModeSet((line,), self.names),
            'poles': self._poles(),
            'spectrum': self._spectrum(),
            'quality': self._quality(),
            'pose': self.pose,
        }
        self.index += 1
        return WindowResult(**{**values, **changes})

    def _mode(self, number):
        true_hz, std = self.frequency_hz[number], 1e-3
        n_channels = len(self.names)
        noise = self.rng.normal(0.0, 0.01, (2, n_channels))
        shape = self.shapes[:, number] / np.abs(self.shapes[:, number]).max()
        shape = shape + noise[0] + 1j * noise[1]
        return Mode(
            frequency_hz=true_hz * (1.0 + std * self.rng.normal()),
            damping_ratio=0.012 + 0.001 * self.rng.normal(),
            shape=shape / shape[np.abs(shape).argmax()],
            frequency_std_hz=std * true_hz,
            damping_ratio_std=0.001,
            mpc=0.99,
            mpd=0.03,
            id=number + 1,
        )

    def _poles(self):
        orders = np.arange(4, 62, 2)
        hz, order, status, row = [], [], [], []
        for number, true_hz in enumerate(self.frequency_hz):
            hz += list(true_hz * (1.0 + 2e-3 * self.rng.normal(size=len(orders))))
            order += list(orders)
            status += [PoleStatus.KEPT] * len(orders)
            row += [number + 1] * len(orders)
        others = [*PoleStatus][1:] * 12
        hz += list(self.rng.uniform(1.0, 80.0, len(others)))
        order += list(self.rng.choice(orders, len(others)))
        status += others
        row += [0] * len(others)
        hz = np.array(hz)
        pole = 2.0 * np.pi * hz * (-0.01 + 1j * np.sqrt(1.0 - 1e-4))
        shape = np.zeros((len(self.names), len(hz)), complex)
        return PoleTable(np.array(order), pole, shape, np.array(status, np.uint8), np.array(row))

    def _spectrum(self):
        hz = np.linspace(0.0, 128.0, 1025)[1:]
        bells = [
            (hz / f) ** 4 / ((1 - (hz / f) ** 2) ** 2 + (0.024 * hz / f) ** 2)
            for f in self.frequency_hz
        ]
        first = 1e-4 * np.sum(bells, axis=0) * self.rng.chisquare(16, len(hz)) / 16
        second = 1e-6 * self.rng.chisquare(16, len(hz))
        return SingularValueSpectrum(hz, np.column_stack([first + second, second]))

    def _quality(self):
        channels = [
            ChannelQuality(
                name, measured_rate_hz=2048.0, rms=0.1 + 0.01 * at, kurtosis=3.0, noise_rms=0.01
            )
            for at, name in enumerate(self.names)
        ]
        channels[2] = ChannelQuality(self.names[2], excluded=True, flags=('clipping',))
        return DataQuality(flags=('degraded',), channels=tuple(channels))


class LiveCell:
    """The node that serves the page, and beside it who publishes as a cell does."""

    def __init__(self, context, **parameters):
        values = {'port': 0, **parameters}
        overrides = [Parameter(name, value=value) for name, value in values.items()]
        self.peer = rclpy.create_node('peer', context=context)
        self.node = DashboardNode(context=context, parameter_overrides=overrides)
        self.publishers = {
            name: self.peer.create_publisher(kind, topic, LATCHED)
            for name, kind, topic in PUBLISHED
        }
        self.diagnostics = self.peer.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.checks, self.state = {}, None
        self.peer.create_timer(0.2, self._repeat)
        self.executor = SingleThreadedExecutor(context=context)
        for node in (self.node, self.peer):
            self.executor.add_node(node)
        self.running = True
        self.thread = threading.Thread(target=self._spin, daemon=True)
        self.thread.start()
        for publisher in (*self.publishers.values(), self.diagnostics):
            self.until(publisher.get_subscription_count)

    @property
    def url(self):
        return self.node.url

    def _spin(self):
        while self.running:
            self.executor.spin_once(timeout_sec=0.02)

    def until(self, happened, timeout_s=40.0):
        deadline = time.monotonic() + timeout_s
        while not happened():
            assert time.monotonic() < deadline, self.node.findings()
            time.sleep(0.01)

    def publish(self, result):
        """Publish a window as an identifier does: the modes, then the diagram."""
        self.publishers['results'].publish(modal_parameters(result, 'base', 0))
        self.publishers['diagrams'].publish(stabilisation_diagram(result, 'base'))
        # An identifier keeps the last one only: the next would be another's.
        self.until(lambda: result.index < self.node.digest.n_windows)

    def tell_state(self, reason='released by the operator', state=BridgeState.RUNNING):
        """Publish what bridge and planner say; the bridge from now on, again and again."""
        self.state = BridgeState(
            backend='abb_egm', controller='127.0.0.1:6510', state=state, reason=reason,
            plan_hash='c0ffee' * 10, progress=0.4, speed_override=1.0, connected=True,
            motors_on=True, controller_state='running', n_received=1200,
            reply_latency_p99_s=4e-4,
        )  # fmt: skip
        self.publishers['plans'].publish(
            ExcitationPlan(
                plan_hash='c0ffee' * 10, robot_name=ROBOT, signal='band_limited_noise',
                duration_s=60.0, band_low_hz=4.0, band_high_hz=60.0, peak_point_speed=0.18,
                torque_projection_rank=3, mode_frequency_hz=[8.3, 11.2, 19.4],
                mode_signal_to_noise_db=[31.0, 28.0, 22.0],
            )
        )  # fmt: skip

    def tell_check(self, name, code='OK', level=DiagnosticStatus.OK, **values):
        """Publish one check from now on, as nodes do, again and again."""
        self.checks[name] = diagnostic(name, code, level, values)

    def _repeat(self):
        if self.state is not None:
            self.publishers['bridge'].publish(self.state)
        self.diagnostics.publish(DiagnosticArray(status=list(self.checks.values())))

    def close(self):
        self.running = False
        self.thread.join()
        self.node.destroy_node()
        self.peer.destroy_node()


@contextmanager
def own_cell(**parameters):
    """Yield a cell in a ROS context of its own, for programs that are no tests."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain())
    live = LiveCell(context, **parameters)
    try:
        yield live
    finally:
        live.close()
        rclpy.try_shutdown(context=context)
