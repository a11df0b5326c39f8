"""The other side of the heartbeat's process: says until when somebody holds."""

from collections.abc import Sequence
import contextlib
import os
import subprocess
import sys
from types import TracebackType
from typing import Self

from autonomous_modal_analysis.operating.beats import BeatReport, PERIOD_S
from modal_core.errors import BridgeError

MODULE = 'autonomous_modal_analysis.operating.beat_node'
# Its loop sees the end of its input within one beat: a hundred of them.
LONGEST_WAIT_S = 100.0 * PERIOD_S
MOST_BYTES = 65536


class BeatProcess:
    """Runs while the ``with`` block does.

    Parameters
    ----------
    namespace : str
        ROS namespace of the cell.
    """

    def __init__(self, namespace: str = '') -> None:
        self._arguments = _arguments(namespace)
        self._process: subprocess.Popen[bytes] | None = None
        self._text, self._report = '', BeatReport()

    def __enter__(self) -> Self:
        """Start it."""
        self._process = subprocess.Popen(  # noqa: S603
            self._arguments,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            # Ctrl-C reaches the operator, who lets go first.
            start_new_session=True,
        )
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                os.set_blocking(pipe.fileno(), False)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End it."""
        process = self._process
        if process is None:
            return
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
        try:
            process.wait(LONGEST_WAIT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def hold(self, token: str, until_s: float) -> None:
        """Beat with this token until a time [s] of the monotonic clock.

        Raises
        ------
        BridgeError
            The process has ended.
        """
        self.check()
        self._tell(token, until_s)

    def let_go(self, token: str) -> None:
        """Beat no more."""
        self._tell(token, 0.0)

    def _tell(self, token: str, until_s: float) -> None:
        process = self._process
        if process is not None and process.stdin is not None:
            line = f'{token} {until_s!r}\n'.encode()
            with contextlib.suppress(BlockingIOError, BrokenPipeError):
                os.write(process.stdin.fileno(), line)

    @property
    def report(self) -> BeatReport:
        """How the beats go."""
        process = self._process
        if process is not None and process.stdout is not None:
            with contextlib.suppress(BlockingIOError):
                self._text += os.read(process.stdout.fileno(), MOST_BYTES).decode()
            *lines, self._text = self._text.split('\n')
            if lines:
                self._report = BeatReport.from_line(lines[-1])
        return self._report

    def check(self) -> None:
        """Raise when the process has ended.

        Raises
        ------
        BridgeError
            It has.
        """
        if self._process is not None and self._process.poll() is not None:
            raise BridgeError('the heartbeat has ended by itself', found=self._process.returncode)


def _arguments(namespace: str) -> Sequence[str]:
    line = [sys.executable, '-P', '-m', MODULE]
    if namespace.strip('/'):
        line += ['--ros-args', '-r', f'__ns:=/{namespace.strip("/")}']
    return line
