"""Results go from the identifier's topic into the file."""

import resource
import signal
import threading
import time

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')
pytestmark = pytest.mark.node

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402
import rclpy  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from sensor_msgs.msg import Temperature  # noqa: E402
from std_msgs.msg import Float64  # noqa: E402

from modal_core.mode import ModeSet  # noqa: E402
from modal_core.nodes.ros_messages import LATCHED  # noqa: E402
from modal_history.alarm import acknowledge  # noqa: E402
from modal_history.history_node import HistoryNode  # noqa: E402
from modal_history.reader import HistoryReader  # noqa: E402
from modal_history.selection import Selection  # noqa: E402
from oma_identifier.node.ros_messages import modal_parameters  # noqa: E402
from oma_identifier.result import WindowResult  # noqa: E402
from oma_msgs.msg import ModalParameters  # noqa: E402
from test.support.kept_results import softened, window  # noqa: E402


class Cell:
    """The node, and beside it who publishes as an identifier does, each spun by a thread."""

    def __init__(self, context, path, **parameters):
        values = {'history': str(path), 'robot': '/robots/arm', **parameters}
        overrides = [Parameter(name, value=value) for name, value in values.items()]
        self.identifier = rclpy.create_node('oma_identifier', context=context)
        self.identifier.declare_parameter('window_s', 60.0)
        self.results = self.identifier.create_publisher(
            ModalParameters, '~/modal_parameters', LATCHED
        )
        self.node = HistoryNode(context=context, parameter_overrides=overrides)
        self.executor = SingleThreadedExecutor(context=context)
        for node in (self.node, self.identifier):
            self.executor.add_node(node)
        self.running = True
        self.thread = threading.Thread(target=self._spin, daemon=True)
        self.thread.start()

    def _spin(self):
        while self.running:
            self.executor.spin_once(timeout_sec=0.05)

    def publish(self, number, rng):
        self.until(self.results.get_subscription_count)
        given = window(number, rng)
        names = ('index', 'start_ns', 'end_ns', 'modes', 'quality', 'pose')
        values = {name: getattr(given, name) for name in names}
        none = ModeSet((), given.modes.channel_names)
        result = WindowResult(**values, harmonics=none, poles=None, spectrum=None)
        self.results.publish(modal_parameters(result, 'base', 0))

    def until(self, happened, timeout_s=40.0):
        deadline = time.monotonic() + timeout_s
        while not happened():
            assert time.monotonic() < deadline, (self.node.n_written, self.node.findings())
            time.sleep(0.02)

    def close(self):
        self.running = False
        self.thread.join()
        self.node.destroy_node()
        self.identifier.destroy_node()


def kept(path):
    with HistoryReader(path) as reader:
        return list(reader.windows(Selection('arm')))


@pytest.mark.smoke
def test_windows_are_kept_with_what_they_depend_on(ros_context, tmp_path):
    path, rng = tmp_path / 'arm.history', np.random.default_rng(1)
    cell = Cell(ros_context, path, tool='gripper', temperature_topic='hall', load_topic='load')
    try:
        hall = cell.identifier.create_publisher(Temperature, 'hall', 10)
        load = cell.identifier.create_publisher(Float64, 'load', 10)
        cell.publish(0, rng)
        cell.until(lambda: cell.node.n_written == 1)
        cell.until(lambda: hall.get_subscription_count() and load.get_subscription_count())
        hall.publish(Temperature(temperature=31.5))
        load.publish(Float64(data=7.0))
        time.sleep(0.5)
        cell.publish(1, rng)
        cell.until(lambda: cell.node.n_written == 2)
    finally:
        cell.close()
    (told, first), (_, second) = kept(path)
    assert told.tool == 'gripper' and '"window_s": 60.0' in told.settings
    assert np.isnan(first.temperature_c) and np.isnan(first.load_kg)
    assert (second.temperature_c, second.load_kg) == (31.5, 7.0)
    assert second.pose.joint_names == ('joint_1', 'joint_2')
    assert [mode.id for mode in second.modes] == [1, 2, 3, 4]
    assert second.quality.channels[0].flags == ('clipping',)


def test_a_node_that_starts_again_goes_on(ros_context, tmp_path):
    """The last result is latched: it comes again, and is kept once."""
    path, rng = tmp_path / 'arm.history', np.random.default_rng(2)
    for first in (0, 5):
        cell = Cell(ros_context, path)
        try:
            for number in range(first, first + 3):
                cell.publish(number, rng)
            cell.until(lambda cell=cell: cell.node.n_written >= 3)
        finally:
            cell.close()
    found = [window for _, window in kept(path)]
    assert [window.index for window in found] == [0, 1, 2, 5, 6, 7]
    assert {mode.id for window in found for mode in window.modes} == {1, 2, 3, 4}


def test_results_wait_for_a_disk_that_is_full(ros_context, tmp_path):
    path, rng = tmp_path / 'arm.history', np.random.default_rng(3)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    cell = Cell(ros_context, path)
    try:
        cell.publish(0, rng)
        cell.until(lambda: cell.node.n_written == 1)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
        for number in (1, 2, 3):
            cell.publish(number, rng)
        cell.until(lambda: cell.node.findings())
        assert [code for code, _ in cell.node.findings()] == ['HISTORY_NOT_WRITTEN']
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        cell.until(lambda: cell.node.n_written == 4)
        assert cell.node.findings() == []
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)
        cell.close()
    assert [window.index for _, window in kept(path)] == [0, 1, 2, 3]


def test_without_a_file_nothing_is_kept(ros_context):
    node = HistoryNode(context=ros_context)
    assert node.writer is None and node.findings() == []
    node.destroy_node()


def test_a_change_is_on_diagnostics_until_it_is_acknowledged(ros_context, tmp_path):
    path = softened(tmp_path / 'arm.history')
    cell = Cell(ros_context, path, baseline_days=0.08, alarm_period_s=1.0)
    told = []
    cell.identifier.create_subscription(DiagnosticArray, '/diagnostics', told.append, 10)

    def status():
        found = [each for message in told for each in message.status if 'alarms' in each.name]
        return found[-1] if found else DiagnosticStatus()

    try:
        cell.until(lambda: status().message == 'NATURAL_FREQUENCY_CHANGED')
        assert status().level == DiagnosticStatus.WARN
        (value,) = status().values
        assert value.key == 'alarm 1' and 'mode 1' in value.value and 'since 2026' in value.value
        acknowledge(path, 1)
        cell.until(lambda: status().message == 'OK')
    finally:
        cell.close()
