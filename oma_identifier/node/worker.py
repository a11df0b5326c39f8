"""Identifies windows in a thread of its own; too many at once are skipped and counted."""

from collections.abc import Callable
from dataclasses import dataclass
import queue
import threading

from modal_core.errors import ModalAnalysisError
from modal_core.window import Window
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.result import WindowResult

# Beside the one that is looked at: a window that takes up to three hops of time delays the next
# ones and loses none; a computer that is too slow for good skips, and says so.
MOST_WAITING = 2


@dataclass(frozen=True, slots=True)
class Job:
    """One window and the pipeline it came from."""

    pipeline: IdentificationPipeline
    window: Window


class IdentificationWorker:
    """A thread that identifies one window after the other.

    Parameters
    ----------
    publish : callable
        Told every result, in the thread.
    on_error : callable
        Told what went wrong with a window, in the thread.
    """

    def __init__(
        self, publish: Callable[[WindowResult], None], on_error: Callable[[str], None]
    ) -> None:
        self.n_skipped = 0
        self.n_done = 0
        self._publish = publish
        self._on_error = on_error
        self._jobs: queue.Queue[Job | None] = queue.Queue()
        self._idle = threading.Condition()
        self._n_open = 0
        self._thread = threading.Thread(target=self._run, name='identification', daemon=True)
        self._thread.start()

    @property
    def n_waiting(self) -> int:
        """Windows that were handed over and are not begun."""
        return self._jobs.qsize()

    def submit(self, job: Job, *, may_skip: bool = True) -> bool:
        """Hand over a window; False when it was skipped because others wait."""
        with self._idle:
            if may_skip and self._n_open > MOST_WAITING:
                self.n_skipped += 1
                return False
            self._n_open += 1
        self._jobs.put(job)
        return True

    def wait_idle(self, timeout_s: float) -> bool:
        """Wait until all windows are identified; False when time ran out."""
        with self._idle:
            return self._idle.wait_for(lambda: self._n_open == 0, timeout_s)

    def stop(self, timeout_s: float) -> None:
        """End the thread after the window it is at; windows that wait are dropped."""
        while True:
            try:
                self._jobs.get_nowait()
            except queue.Empty:
                break
        self._jobs.put(None)
        self._thread.join(timeout_s)

    def _run(self) -> None:
        while True:
            job = self._jobs.get()
            if job is None:
                return
            try:
                self._publish(job.pipeline.identify(job.window))
            except (ModalAnalysisError, ArithmeticError, ValueError) as error:
                # numpy's LinAlgError is a ValueError; one bad window must not end the node.
                self._on_error(f'window {job.window.index}: {error}')
            except (MemoryError, RuntimeError, LookupError, TypeError, OSError) as error:
                # A thread that ends would leave the node alive and without results for good.
                said = f'{type(error).__name__}: {error}'
                self._on_error(f'window {job.window.index} failed: {said}')
            finally:
                self.n_done += 1
                with self._idle:
                    self._n_open -= 1
                    self._idle.notify_all()
