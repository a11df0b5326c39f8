"""Keys of a terminal as they come, each with a time it cannot be older than."""

from collections.abc import Sequence
import contextlib
import os
import select
import sys
import termios
import tty
from types import TracebackType
from typing import Any, Self

from modal_core.errors import SettingsError

MOST_TYPED_BYTES = 4096


def check_terminal(descriptor: int | None = None) -> None:
    """Refuse to hold a key where there is none.

    Raises
    ------
    SettingsError
        Standard input, or what else is given, is no terminal.
    """
    if not os.isatty(sys.stdin.fileno() if descriptor is None else descriptor):
        raise SettingsError(
            'no terminal to hold a key in',
            where='standard input',
            advice='run it in a terminal, or hold a button: --joy',
        )


class Keyboard:
    """Gives every key at once, without echo, while the ``with`` block runs.

    The system does not say when a key was pressed.  It lies between the last look that found
    nothing more and now: the earlier is taken, so that keys that piled up while this process
    stood still never count as pressed just now.

    Parameters
    ----------
    descriptor : int or None
        Of the terminal; None takes standard input.

    Raises
    ------
    SettingsError
        It is no terminal.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._descriptor = sys.stdin.fileno() if descriptor is None else descriptor
        check_terminal(self._descriptor)
        self._before: list[Any] = []
        self._empty_s = 0.0

    def __enter__(self) -> Self:
        """Take the keys; what was typed before is dropped."""
        self._before = termios.tcgetattr(self._descriptor)
        # Not raw: Ctrl-C still interrupts.
        tty.setcbreak(self._descriptor, termios.TCSAFLUSH)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Give the terminal back; repeats of a key still held are dropped."""
        with contextlib.suppress(termios.error):  # the terminal may be gone
            termios.tcsetattr(self._descriptor, termios.TCSAFLUSH, self._before)

    def begin(self, now_s: float) -> None:
        """Count from now [s]."""
        termios.tcflush(self._descriptor, termios.TCIFLUSH)
        self._empty_s = now_s

    def look(self, now_s: float) -> tuple[Sequence[str], float]:
        """Return the keys that came since the last look, and the time [s] they cannot be before.

        A terminal that is gone gives the key ''.
        """
        ready, _, _ = select.select([self._descriptor], [], [], 0.0)
        since_s, self._empty_s = self._empty_s, now_s
        if not ready:
            return (), now_s
        try:
            keys = os.read(self._descriptor, MOST_TYPED_BYTES)
        except OSError:
            keys = b''
        return tuple(keys.decode(errors='replace')) or ('',), since_s
