"""A process that ends when the one that started it does, even by SIGKILL."""

from collections.abc import MutableMapping
import contextlib
import ctypes
import os
import signal

STARTED_BY = 'AMA_STARTED_BY'
SET_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG, prctl(2): Linux


def started_by_this() -> dict[str, str]:
    """Return what a process's environment must hold to end with this one."""
    return {STARTED_BY: str(os.getpid())}


def end_with_starter(environment: MutableMapping[str, str] = os.environ) -> None:
    """Let this process be told to end, as by SIGTERM, once what started it is gone.

    Does nothing for a process that was not started so, or where no such signal exists.  What it
    starts itself is not concerned.
    """
    starter = environment.pop(STARTED_BY, '')
    if not starter:
        return
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(SET_DEATH_SIGNAL, signal.SIGTERM)
    if os.getppid() != int(starter):  # gone before it could be asked for
        signal.raise_signal(signal.SIGTERM)
