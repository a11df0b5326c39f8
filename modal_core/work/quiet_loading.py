"""Ctrl-C while a program still loads ends it, without a traceback of half-loaded modules."""

from collections.abc import Iterator
from contextlib import contextmanager
import signal
import threading


@contextmanager
def quiet_loading() -> Iterator[None]:
    """Let an interrupt end the process at once, as it does programs that handle none.

    Nothing has been started then that needs an end of its own; SIGTERM does so by itself.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    if before not in (signal.default_int_handler, signal.SIG_DFL):
        # Ignored by who started the process, or handled: as it was.
        signal.signal(signal.SIGINT, before)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
