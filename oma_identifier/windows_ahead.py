"""Windows of a recording in two processes: one looks for modes, the other makes windows ready."""

from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack
import logging
from types import TracebackType

from modal_core.samples import Samples
from modal_core.window import Window
from modal_core.work.beside import Beside, can_work_beside
from modal_core.work.free_memory import LARGE_BYTES
from oma_identifier.motion import PeakTest
from oma_identifier.pipeline import BegunWindow, IdentificationPipeline
from oma_identifier.result import WindowResult
from oma_identifier.selection import Identified

MOST_WAITING = 2
"""Windows held that wait for their modes, beside the newest: one that is looked at and one that
is next, so that neither process waits for a step that takes longer than usual."""

Wanted = tuple[Samples, PeakTest]


class WindowsAhead:
    """Identifies window after window as the pipeline alone would, to the last bit.

    While one window is looked at in a process of its own, the next ones are read, cleaned and put
    in step here.  A record of one window, or a machine with one processor, needs no other process.
    Nor do windows so large that memory counts more, or who wants to know why modes were turned
    down, which only this process can say.
    """

    def __init__(self, pipeline: IdentificationPipeline) -> None:
        self._pipeline = pipeline
        self._waiting: deque[BegunWindow] = deque()
        self._stack = ExitStack()
        self._beside: Beside[Wanted, Identified] | None = None
        says_reasons = logging.getLogger(__package__).isEnabledFor(logging.DEBUG)
        self._is_alone = says_reasons or not can_work_beside()

    def __enter__(self) -> 'WindowsAhead':
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    def identify(self, window: Window) -> Iterator[WindowResult]:
        """Take in a window; yield the results that are due, in the order of the windows."""
        begun = self._pipeline.begin(window)
        if self._beside is None:
            self._is_alone |= window.samples.acceleration.nbytes >= LARGE_BYTES
            if self._waiting and not self._is_alone:
                self._start()
        self._waiting.append(begun)
        self._ask(begun)
        del begun  # Large, and held by those that wait.
        while len(self._waiting) > (0 if self._is_alone else MOST_WAITING):
            yield self._oldest()

    def rest(self) -> Iterator[WindowResult]:
        """Yield the results of all windows that are left; none comes any more."""
        if self._beside is not None:
            self._pipeline.record.look_ahead()
        while self._waiting:
            yield self._oldest()

    def _start(self) -> None:
        self._beside = self._stack.enter_context(Beside(self._answer))
        for earlier in self._waiting:
            self._ask(earlier)

    def _ask(self, begun: BegunWindow) -> None:
        if self._beside is not None and begun.cleaned is not None:
            self._beside.put(begun.wanted)

    def _oldest(self) -> WindowResult:
        begun = self._waiting.popleft()
        return self._pipeline.conclude(begun, lambda: self._found(begun))

    def _found(self, begun: BegunWindow) -> Identified:
        if self._beside is None:
            return self._pipeline.finder.find(*begun.wanted)
        return self._beside.result()

    def _answer(self, wanted: Wanted) -> Identified:
        return self._pipeline.finder.find(*wanted)
