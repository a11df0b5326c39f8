"""A web server on a thread of its own."""

import asyncio
from collections.abc import Callable, Coroutine
import threading
from typing import Any

from aiohttp import web

Listen = Callable[[web.AppRunner], Coroutine[Any, Any, None]]


class ThreadedServer:
    """Serves an application until it is closed.

    Parameters
    ----------
    runner : AppRunner
        Of the application.
    listen : callable
        Opens the sites of the runner, which is set up; what it raises as `OSError` is raised here.
    name : str
        Of the thread.
    start_s : float [s]
        How long starting and stopping may take.
    beside : callable or None
        What runs in the same loop for as long as it serves.
    end : callable or None
        Called in the loop's thread when serving ends, before connections are closed.

    Attributes
    ----------
    loop : AbstractEventLoop
        Of the thread.

    Raises
    ------
    OSError
        It cannot listen there.
    """

    def __init__(
        self,
        runner: web.AppRunner,
        listen: Listen,
        name: str,
        start_s: float,
        beside: Callable[[], Coroutine[Any, Any, None]] | None = None,
        end: Callable[[], None] | None = None,
    ) -> None:
        self.loop = asyncio.new_event_loop()
        self._runner, self._listen, self._start_s = runner, listen, start_s
        self._beside, self._end = beside, end
        self._failure: OSError | None = None
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._serve, name=name, daemon=True)
        self._thread.start()
        self._ready.wait(start_s)
        if self._failure is not None:
            raise self._failure

    def call(self, function: Callable[..., None], *given: object) -> None:
        """Have the loop call a function, from any thread; nothing after it was closed."""
        if not self.loop.is_closed():
            self.loop.call_soon_threadsafe(function, *given)

    def close(self) -> None:
        """Stop serving."""
        if self._thread.is_alive():
            self.loop.call_soon_threadsafe(self.loop.stop)
            self._thread.join(self._start_s)

    def _serve(self) -> None:
        asyncio.set_event_loop(self.loop)
        try:
            self.loop.run_until_complete(self._runner.setup())
            self.loop.run_until_complete(self._listen(self._runner))
        except OSError as error:
            self._failure = error
        self._ready.set()
        if self._failure is None:
            self._run()
        self.loop.run_until_complete(self._runner.cleanup())
        self.loop.close()

    def _run(self) -> None:
        task = self.loop.create_task(self._beside()) if self._beside is not None else None
        self.loop.run_forever()
        if task is not None:
            task.cancel()
        if self._end is not None:
            self._end()
