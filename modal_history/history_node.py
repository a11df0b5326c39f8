"""Keeps every result of an identifier."""

from collections import deque
from collections.abc import Sequence
import json
import math
from pathlib import Path
import threading
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from modal_core.errors import HistoryError
from modal_core.files.version import software
from modal_core.nodes.ros_messages import declare_parameters, diagnostic, RESULTS
from modal_core.nodes.run_node import run_node
from modal_history.alarm import (
    Alarm,
    AlarmCheck,
    alarms_of,
    BaselineSettings,
    keep_alarms,
    RobotParts,
    WatchSettings,
)
from modal_history.kept import Circumstances, KeptWindow
from modal_history.node_parameters import PARAMETERS
from modal_history.reader import HistoryReader
from modal_history.ros_messages import kept_window
from modal_history.store import HistoryWriter
from oma_msgs.msg import ModalParameters

WRITE_PERIOD_S = 0.5
DIAGNOSTICS_PERIOD_S = 1.0
AGAIN_S = 5.0
"""Between attempts to write what could not be written, and until settings count as unknown: a disk
is freed by a person, and 5 s are far below the 90 s from one result to the next."""
STALE_S = 600.0
"""A temperature or a load that was told longer ago is not known any more: gears warm up within an
hour or two, so that in ten minutes a temperature goes a sixth of what is left of its way."""
CHANGED, LOST = 'NATURAL_FREQUENCY_CHANGED', 'MODE_LOST'
MOST_WAITING = 1000
"""Results that wait for a disk: a day of one every 90 s, some 50 MB."""


class HistoryNode(Node):
    """Takes windows as they come and adds them to the history; what fails is tried again."""

    def __init__(self, **options: Any) -> None:
        super().__init__('modal_history', **options)
        declare_parameters(self, PARAMETERS)
        path = self._value('history')
        self.writer = HistoryWriter(Path(path)) if path else None
        self.n_written = self.n_lost = 0
        self.problem = ''
        self._waiting: deque[KeptWindow] = deque()
        self._settings: str | None = None
        self._again_ns = self._asked_ns = 0
        self._told: dict[str, tuple[float, int]] = {}
        self.alarms: tuple[Alarm, ...] = ()
        self.unchecked = ''
        self._checking: threading.Thread | None = None
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.create_timer(DIAGNOSTICS_PERIOD_S, self._publish_diagnostics)
        if self.writer is None:
            self.get_logger().info('no history is named: nothing is kept')
            return
        self._identifier = self.resolve_service_name(self._value('identifier'))
        self._client = AsyncParameterClient(self, self._identifier)
        self._listen()
        self.create_timer(WRITE_PERIOD_S, self.write)
        baseline = BaselineSettings(days=self._value('baseline_days'))
        watching = WatchSettings(self._value('false_a_month'))
        self._check = AlarmCheck(baseline, watching, RobotParts(self._value('robot')))
        self.create_timer(self._value('alarm_period_s'), self.check_alarms)

    def _listen(self) -> None:
        self.create_subscription(
            ModalParameters, f'{self._identifier}/modal_parameters', self._take, RESULTS
        )
        self.create_subscription(ParameterEvent, '/parameter_events', self._on_event, 100)
        for name, kind, field in (
            ('temperature', Temperature, 'temperature'),
            ('load', Float64, 'data'),
        ):
            topic = self._value(f'{name}_topic')
            if topic:
                self.create_subscription(
                    kind,
                    topic,
                    lambda message, name=name, field=field: self._note(
                        name, getattr(message, field)
                    ),
                    10,
                )

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _now_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)

    # -- input -----------------------------------------------------------------------------

    def _take(self, message: ModalParameters) -> None:
        try:
            window = kept_window(message, self._known('temperature'), self._known('load'))
        except (ValueError, TypeError, OverflowError) as error:
            self.problem = f'a result that cannot be kept: {error}'
            self.n_lost += 1
            return
        if len(self._waiting) >= MOST_WAITING:
            self._waiting.popleft()
            self.n_lost += 1
        self._waiting.append(window)

    def _note(self, name: str, value: float) -> None:
        self._told[name] = (float(value), self._now_ns())

    def _known(self, name: str) -> float:
        value, when = self._told.get(name, (math.nan, 0))
        return value if self._now_ns() - when < STALE_S * 1e9 else math.nan

    # -- the identifier's settings ---------------------------------------------------------

    def _on_event(self, event: ParameterEvent) -> None:
        if event.node == self._identifier:
            self._settings, self._asked_ns = None, 0

    def _ask(self) -> None:
        """Ask for all parameters of the identifier; the answer comes by itself."""
        self._asked_ns = self._now_ns()
        if self._client.services_are_ready():
            self._client.list_parameters().add_done_callback(self._on_names)

    def _on_names(self, future: Future) -> None:
        names = sorted(future.result().result.names)
        found = self._client.get_parameters(names)
        found.add_done_callback(lambda answer: self._on_values(names, answer))

    def _on_values(self, names: Sequence[str], future: Future) -> None:
        values = map(parameter_value_to_python, future.result().values)
        # Lists come as arrays.
        self._settings = json.dumps(
            dict(zip(names, values, strict=True)), sort_keys=True, default=list
        )

    def _settings_text(self) -> str | None:
        """Return the settings; None while they are waited for, empty where nobody tells."""
        if self._settings is None and not self._asked_ns:
            self._ask()
        if self._settings is None and self._now_ns() - self._asked_ns < AGAIN_S * 1e9:
            return None
        return self._settings or ''

    # -- alarms ------------------------------------------------------------------------------

    def check_alarms(self) -> None:
        """Look for changes on a thread of its own: a baseline takes seconds to learn."""
        if self._checking is None or not self._checking.is_alive():
            self._checking = threading.Thread(target=self._look, daemon=True)
            self._checking.start()

    def _look(self) -> None:
        robot, path = Path(self._value('robot')).name, Path(self._value('history'))
        try:
            with HistoryReader(path) as reader:
                found = self._check.check(reader, robot)
            if found.new or found.told:
                keep_alarms(path, (*found.new, *found.told))
            self.unchecked = ''
        except HistoryError as error:
            self.unchecked = str(error)

    def _open_alarms(self) -> tuple[Alarm, ...]:
        """Return the alarms nobody has taken note of; the last ones where none can be read."""
        if self.writer is not None:
            try:
                found = alarms_of(self.writer.file)
                self.alarms = tuple(alarm for alarm in found if alarm.is_open)
            except HistoryError as error:
                self.unchecked = str(error)
        return self.alarms

    # -- output ----------------------------------------------------------------------------

    def write(self, patient: bool = True) -> None:
        """Write all that waits; what cannot be written goes on waiting."""
        settings = self._settings_text() if self._waiting else None
        if self.writer is None or not self._waiting or (patient and settings is None):
            return
        if patient and self._now_ns() < self._again_ns:
            return
        circumstances = Circumstances(
            robot=Path(self._value('robot')).name,
            tool=self._value('tool'),
            software=software(),
            settings=settings or '',
        )
        try:
            added = self.writer.add(circumstances, list(self._waiting))
        except HistoryError as error:
            self.problem, self._again_ns = str(error), self._now_ns() + int(AGAIN_S * 1e9)
            self.get_logger().error(self.problem, throttle_duration_sec=60.0)
            return
        self._waiting.clear()
        self.problem = ''
        self.n_written += added.n_new

    def findings(self) -> list[tuple[str, str]]:
        """Return code and text of what is wrong."""
        found = []
        if self.problem:
            found.append(('HISTORY_NOT_WRITTEN', self.problem))
        if self.n_lost:
            found.append(('HISTORY_LOST', f'{self.n_lost} results could not be kept'))
        return found

    def _publish_diagnostics(self) -> None:
        found, own = self.findings(), self.get_fully_qualified_name()
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        values = {**dict(found), 'written': self.n_written, 'waiting': len(self._waiting)}
        code = found[0][0] if found else ('OK' if self.writer else 'OK: nothing is kept')
        level = DiagnosticStatus.ERROR if found else DiagnosticStatus.OK
        message.status = [
            diagnostic(f'{own}: history', code, level, values, own),
            self._alarm_status(own),
        ]
        self._diagnostics.publish(message)

    def _alarm_status(self, own: str) -> DiagnosticStatus:
        values = {f'alarm {alarm.number}': alarm.words() for alarm in self._open_alarms()}
        lost = any(alarm.change.kind == 'lost' for alarm in self.alarms)
        code, level = (LOST if lost else CHANGED, DiagnosticStatus.WARN)
        if not values:
            code, level = 'OK', DiagnosticStatus.OK
        if self.unchecked:
            values['NOT_CHECKED'] = self.unchecked
            code = code if level == DiagnosticStatus.WARN else 'NOT_CHECKED'
            level = DiagnosticStatus.WARN
        return diagnostic(f'{own}: alarms', code, level, values, own)

    def destroy_node(self) -> None:
        """Write what waits, and close the file."""
        if self._checking is not None:
            self._checking.join()
        if self.writer is not None:
            self.write(patient=False)
            self.writer.file.close()
        super().destroy_node()


def main(args: Sequence[str] | None = None) -> None:
    """Run the node until it is told to stop."""
    run_node('modal_history', HistoryNode, args=args)


if __name__ == '__main__':
    main()
