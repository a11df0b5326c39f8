"""Turns what came into updates, on a thread of its own: callbacks only hand messages over."""

from collections.abc import Callable, Sequence
import queue
import threading
import time

from modal_dashboard.drawn_arm import DrawnArm
from modal_dashboard.screens import (
    BridgeNews,
    Check,
    Checks,
    Diagram,
    diagram_update,
    PlanNews,
    RunLog,
    SILENT_S,
    window_updates,
)
from modal_history.kept import KeptWindow

MOST_WAITING = 100
"""A burst of a replay; beyond it the oldest go: the page shows what is now."""
QUIET_S = 0.01
"""A diagram comes just behind its window; an arm's first picture takes a tenth of a second.  With
so long a wait spectrum and shapes are seen after 39 and 49 ms in the median (benchmark ``page``);
with 50 ms no shapes were within 50."""
Work = Callable[[], None]
Send = Callable[..., None]


class Digest:
    """Keeps what belongs together and sends what changed.

    Parameters
    ----------
    send : callable
        Takes updates.
    arm : DrawnArm
        That shapes are drawn on.
    namespace : str
        Of the cell.
    """

    def __init__(self, send: Send, arm: DrawnArm, namespace: str) -> None:
        self._send, self._arm = send, arm
        self._checks, self._log = Checks(namespace), RunLog()
        self._window: KeptWindow | None = None
        self._diagram: Diagram | None = None
        self._undrawn: KeptWindow | None = None
        self._bridge: BridgeNews | None = None
        self._bridge_s = 0.0
        self.n_windows = self.n_refused = self.n_skipped = 0
        self._work = queue.Queue[Work | None](MOST_WAITING)
        self._thread = threading.Thread(target=self._run, name='digest', daemon=True)
        self._thread.start()

    def hand(self, take: Callable[..., None], read: Callable[..., object], *given: object) -> None:
        """Have ``take`` take what ``read`` makes of a message; at once, whatever waits."""
        while True:
            try:
                self._work.put_nowait(lambda: take(read(*given)))
            except queue.Full:
                self._forget_oldest()
            else:
                return

    def close(self) -> None:
        """Stop after what is in work."""
        while self._thread.is_alive():
            try:
                self._work.put_nowait(None)
                break
            except queue.Full:
                self._forget_oldest()
        self._thread.join()

    # -- what comes ----------------------------------------------------------------------------

    def window(self, window: KeptWindow) -> None:
        """Show a result; its shapes, which take longer, when nothing else waits."""
        before, self._window = self._window, window
        now_s = time.time()
        # A latched result comes again after a restart of its publisher.
        if before is not None and before.end_ns == window.end_ns:
            return
        self._send(*window_updates(window, before, now_s), *self._log.window(window, now_s))
        self._lines()
        self._undrawn = window
        self.n_windows += 1

    def diagram(self, diagram: Diagram) -> None:
        """Show poles and spectrum."""
        self._diagram = diagram
        self._lines()

    def checks(self, checks: Sequence[Check]) -> None:
        """Show what nodes say of themselves."""
        changed = self._checks.take(checks, time.monotonic())
        self._send(*self._checks.updates())
        self._look_after_bridge()
        for check in changed:
            self._send(*self._log.check(check, time.time()))

    def bridge(self, news: BridgeNews) -> None:
        """Show the state of the bridge."""
        self._bridge, self._bridge_s = news, time.monotonic()
        self._send(news.update(), *self._log.bridge(news, time.time()))

    def _look_after_bridge(self) -> None:
        """Say so once when the bridge falls silent; called every second by our own check."""
        if self._bridge is not None and time.monotonic() - self._bridge_s > SILENT_S:
            silent, self._bridge = self._bridge.silent(), None
            self._send(silent.update(), *self._log.bridge(silent, time.time()))

    def plan(self, news: PlanNews) -> None:
        """Show a plan."""
        self._send(news.update(), *self._log.plan(news, time.time()))

    def _lines(self) -> None:
        """Draw a diagram with the lines of its own window, whichever of both came first."""
        window, diagram = self._window, self._diagram
        if diagram is not None:
            own = window is not None and window.index == diagram.index
            self._send(diagram_update(diagram, window.modes if window and own else ()))

    # -- the thread ----------------------------------------------------------------------------

    def _run(self) -> None:
        while (work := self._next()) is not None:
            try:
                work()
            except (ValueError, TypeError, OverflowError) as error:
                self.n_refused += 1
                words = f'a message that cannot be shown: {error}'
                self._send(*self._log.refused(words[:300], time.time()))

    def _next(self) -> Work | None:
        """Return what to do next: shapes once a moment passes in which nothing comes."""
        try:
            return self._work.get(timeout=None if self._undrawn is None else QUIET_S)
        except queue.Empty:
            return self._draw

    def _draw(self) -> None:
        window, self._undrawn = self._undrawn, None
        if window is not None:
            self._send(self._arm.update(window))

    def _forget_oldest(self) -> None:
        try:
            self._work.get_nowait()
            self.n_skipped += 1
        except queue.Empty:
            return
