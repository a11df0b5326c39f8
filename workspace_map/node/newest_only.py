"""Work that takes longer than its orders come: done in a thread, of the newest order only."""

from collections.abc import Callable
import threading
from typing import Generic, TypeVar

Order = TypeVar('Order')


class NewestOnly(Generic[Order]):
    """Does one piece of work after the other; what was ordered and not begun gives way.

    Parameters
    ----------
    work : callable
        Takes an order, in the thread; it raises nothing.
    """

    def __init__(self, work: Callable[[Order], None]) -> None:
        self._work = work
        self._changed = threading.Condition()
        self._order: Order | None = None
        self._running = True
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def submit(self, order: Order) -> None:
        """Order work; from any thread."""
        with self._changed:
            self._order = order
            self._changed.notify()

    def stop(self, timeout_s: float) -> None:
        """End the thread after the work it is at."""
        with self._changed:
            self._running = False
            self._changed.notify()
        self._thread.join(timeout_s)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._order is not None or not self._running)
                if not self._running or self._order is None:
                    return
                order, self._order = self._order, None
            self._work(order)
