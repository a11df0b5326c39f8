"""One browser that looks, with a short queue of its own."""

import asyncio
from collections.abc import Iterable

from aiohttp import web

MOST_WAITING = 64
"""Messages for one browser: some ten seconds of a lively cell."""
LONGEST_SEND_S = 5.0


class Viewer:
    """Sends to one browser; one that does not keep up is let go, never waited for.

    Its page connects again by itself, and is told everything anew.

    Parameters
    ----------
    socket : WebSocketResponse
        Prepared.
    request : Request
        It came by.
    first : iterable of str
        Messages before all others.
    """

    def __init__(
        self, socket: web.WebSocketResponse, request: web.Request, first: Iterable[str]
    ) -> None:
        self._socket, self._request, self._first = socket, request, tuple(first)
        self._waiting = asyncio.Queue[str](MOST_WAITING)
        self.was_slow = False

    def tell(self, text: str) -> None:
        """Queue a message."""
        try:
            self._waiting.put_nowait(text)
        except asyncio.QueueFull:
            self.drop()

    async def send(self) -> None:
        """Send what is queued until the connection ends."""
        try:
            for text in self._first:
                await self._send(text)
            while True:
                await self._send(await self._waiting.get())
        except TimeoutError:
            self.drop()
        except ConnectionError:
            return

    async def _send(self, text: str) -> None:
        await asyncio.wait_for(self._socket.send_str(text), LONGEST_SEND_S)

    def drop(self) -> None:
        """Cut the connection, without a word that would have to be waited for as well."""
        self.was_slow = True
        if self._request.transport is not None:
            self._request.transport.abort()
