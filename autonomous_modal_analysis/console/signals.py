"""Signals that end a command, wherever they find it."""

import signal
import sys
from typing import Any

ENDING = (signal.SIGTERM, signal.SIGHUP)
AGAIN_S = 0.01
"""Until the end that was swallowed is raised once more."""


def prepare_signals() -> None:
    """Let signals end the process as an exception, so that what it has started ends with it.

    Where Python runs on behalf of its own memory, in a weak reference's last call or in
    ``__del__``, it drops exceptions with a traceback; an end that was dropped is raised again.
    """
    for number in ENDING:
        signal.signal(number, _end)
    sys.unraisablehook = _raised_in_vain


def _end(received: int, _: Any) -> None:
    sys.exit(128 + received)


def _raised_in_vain(dropped: 'sys.UnraisableHookArgs') -> None:
    number = _signal_of(dropped.exc_value)
    if number is None:
        sys.__unraisablehook__(dropped)
        return
    signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(number))
    signal.setitimer(signal.ITIMER_REAL, AGAIN_S)


def _signal_of(error: BaseException | None) -> signal.Signals | None:
    """Return the signal that an exception comes of; None where it comes of none."""
    if isinstance(error, KeyboardInterrupt):
        return signal.SIGINT
    if isinstance(error, SystemExit):
        return next((number for number in ENDING if error.code == 128 + number), None)
    return None
