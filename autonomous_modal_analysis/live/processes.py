"""Start the nodes as processes of their own and stop them cleanly."""

from collections.abc import Mapping, Sequence
import contextlib
from dataclasses import dataclass, field
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import threading
import time
from types import TracebackType
from typing import IO, Self

from modal_core.errors import ModalAnalysisError
from modal_core.nodes.started_by import started_by_this

LONGEST_STOP_S = 10.0
CHECK_EVERY_S = 0.5
SINGLE_BLAS_THREAD = {
    'OPENBLAS_NUM_THREADS': '1',
    'OMP_NUM_THREADS': '1',
    'MKL_NUM_THREADS': '1',
}


def stop_event() -> threading.Event:
    """Return an event that Ctrl-C and SIGTERM set from now on."""
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    return stop


def all_is_stopped() -> None:
    """Pass over what asks to stop from now on.

    A second Ctrl-C while Python itself ends would be a death by signal.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)


@dataclass(frozen=True, slots=True)
class NodeCommand:
    """How to start one node.

    Parameters
    ----------
    name : str
        Node name.
    module : str
        Python module with the node's ``main``.
    parameter_file : Path or None
        ROS parameter file.
    parameters : mapping
        Parameters that override the file.
    remappings : mapping
        ROS names to remap.
    """

    name: str
    module: str
    parameter_file: Path | None = None
    parameters: Mapping[str, object] = field(default_factory=dict)
    remappings: Mapping[str, str] = field(default_factory=dict)

    def arguments(self, namespace: str = '') -> list[str]:
        """Return the command line of the node's process."""
        # -P: what lies in the folder the command was called from is not code of the nodes.
        line = [sys.executable, '-P', '-m', self.module]
        line += ['--ros-args', '-r', f'__node:={self.name}']
        if namespace:
            line += ['-r', f'__ns:=/{namespace.strip("/")}']
        for source, target in self.remappings.items():
            line += ['-r', f'{source}:={target}']
        if self.parameter_file is not None:
            line += ['--params-file', str(self.parameter_file)]
        for name, value in self.parameters.items():
            line += ['-p', f'{name}:={_yaml_scalar(value)}']
        return line


class NodeProcesses:
    """A group of node processes that lives as long as the ``with`` block.

    Parameters
    ----------
    commands : sequence of NodeCommand
        Nodes, started in this order.
    environment : mapping
        Environment variables on top of this process's own.
    log_folder : Path or None
        Folder for one log file per node; None lets the nodes write to the terminal.
    namespace : str
        ROS namespace of all nodes.
    """

    def __init__(
        self,
        commands: Sequence[NodeCommand],
        *,
        environment: Mapping[str, str] | None = None,
        log_folder: Path | None = None,
        namespace: str = '',
    ) -> None:
        self._commands = tuple(commands)
        self._environment = {**os.environ, **SINGLE_BLAS_THREAD, **(environment or {})}
        self._log_folder = log_folder
        self._namespace = namespace
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self._logs: list[IO[bytes]] = []

    def __enter__(self) -> Self:
        """Start all nodes."""
        try:
            for command in self._commands:
                self._start(command)
        except BaseException as error:
            self.stop()
            if isinstance(error, OSError):
                raise ModalAnalysisError(f'cannot start a node: {error}') from error
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop all nodes."""
        self.stop()

    def check(self) -> None:
        """Raise when a node has ended by itself.

        Raises
        ------
        ModalAnalysisError
            Naming the node, its exit status and the last line it wrote.
        """
        for name, process in self._running.items():
            if process.poll() is not None:
                raise self._ended(name, process.returncode)

    def run_until(self, stop: threading.Event) -> None:
        """Wait until the event is set.

        Raises
        ------
        ModalAnalysisError
            A node ended by itself.
        """
        while not stop.wait(CHECK_EVERY_S):
            self.check()

    def ended_well(self, name: str) -> bool:
        """Return whether a node has come to its own end; False while it runs.

        Raises
        ------
        ModalAnalysisError
            It ended with an error.
        """
        status = self._running[name].poll()
        if status:
            raise self._ended(name, status)
        return status == 0

    def stop(self) -> None:
        """Ask all nodes to stop, then insist; in reverse order of their start."""
        # A second Ctrl-C must not leave nodes behind.
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        # Not SIGINT: a node that is still importing would answer it with a traceback.
        for number in (signal.SIGTERM, signal.SIGKILL):
            deadline = time.monotonic() + LONGEST_STOP_S
            for process in reversed(self._running.values()):
                process.send_signal(number)
            for process in self._running.values():
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(max(0.0, deadline - time.monotonic()))
        signal.signal(signal.SIGINT, before)
        self._running.clear()
        for log in self._logs:
            log.close()
        self._logs.clear()

    def _start(self, command: NodeCommand) -> None:
        output: IO[bytes] | None = None
        path = self._log_path(command.name)
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            output = path.open('wb')
            self._logs.append(output)
        self._running[command.name] = subprocess.Popen(  # noqa: S603
            command.arguments(self._namespace),
            env={**self._environment, **started_by_this()},
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT if output else None,
            # An own session: Ctrl-C reaches the nodes once, from us, and in order.
            start_new_session=True,
        )

    def _ended(self, name: str, status: int) -> ModalAnalysisError:
        return ModalAnalysisError(
            f'node {name} ended by itself with exit status {status}',
            where=self._log_path(name) or '',
            found=self._last_line(name),
        )

    def _log_path(self, name: str) -> Path | None:
        return self._log_folder / f'{name}.log' if self._log_folder else None

    def _last_line(self, name: str) -> str | None:
        path = self._log_path(name)
        if path is None:
            return None
        lines = path.read_text(errors='replace').strip().splitlines()
        return lines[-1] if lines else None


def _yaml_scalar(value: object) -> str:
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, (list, tuple)):
        return f'[{", ".join(_yaml_scalar(item) for item in value)}]'
    if isinstance(value, str):
        # Quoted: a name such as 1e5 or yes must stay a text.
        return json.dumps(value)
    return str(value)
