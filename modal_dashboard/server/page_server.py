"""Serves the page from a thread of its own."""

import asyncio
from collections.abc import Awaitable, Callable
import errno
import logging

from aiohttp import web, WSMsgType

from modal_core.errors import SettingsError
from modal_core.nodes.threaded_server import ThreadedServer
from modal_dashboard.screens import Board, Update
from modal_dashboard.server.access import Access
from modal_dashboard.server.page_files import page_files
from modal_dashboard.server.viewers import Viewer

SILENT = logging.getLogger(__name__)
"""What strangers send must not fill the terminal with tracebacks."""
SILENT.addHandler(logging.NullHandler())
SILENT.propagate = False
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]
PORTS_TRIED = 20
"""From the first on: several cells of one machine have a page each."""
MOST_VIEWERS = 32
START_S = 10.0
BEAT_S = 5.0
"""Between signs of life; the page calls a connection lost after three without any."""
LONGEST_LINE_BYTES = 4096
"""Of a request's first line and of each header; there is never a body."""
HEADERS = {
    'Content-Security-Policy': "default-src 'none'; script-src 'self'; style-src 'self';"
    " connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none';"
    " frame-ancestors 'none'",
    'X-Content-Type-Options': 'nosniff',
    'X-Frame-Options': 'DENY',
    'Referrer-Policy': 'no-referrer',
    'Cross-Origin-Resource-Policy': 'same-origin',
    'Cross-Origin-Opener-Policy': 'same-origin',
    'Cache-Control': 'no-store',
}


class PageServer:
    """The page's files by GET, and a web socket that only sends.

    Parameters
    ----------
    address : str
        Interface to listen on.
    port : int
        First TCP port to try; 0 takes a free one.
    access : Access
        Who may look.

    Attributes
    ----------
    port : int
        Where it listens.
    n_slow : int
        Browsers that were let go because they did not keep up.

    Raises
    ------
    SettingsError
        It cannot listen there.
    """

    def __init__(self, address: str, port: int, access: Access) -> None:
        self.port, self.n_slow = port, 0
        self._address, self._access = address, access
        self._files = page_files()
        self._board, self._viewers = Board(), set[Viewer]()
        try:
            self._server = ThreadedServer(
                self._runner(), self._listen, 'page', START_S, self._beat, self._drop_viewers
            )
        except OSError as error:
            raise SettingsError(
                'the page cannot be served',
                where=f'{address}:{port}',
                found=error.strerror,
                advice='name an address of this machine and a free port',
            ) from error

    @property
    def n_viewers(self) -> int:
        """Browsers that look."""
        return len(self._viewers)

    def send(self, *updates: Update) -> None:
        """Tell all browsers, from any thread."""
        self._server.call(self._publish, updates)

    def close(self) -> None:
        """Stop serving."""
        self._server.close()

    # -- serving -------------------------------------------------------------------------------

    def _runner(self) -> web.AppRunner:
        # One byte is too large a body: no request has one.
        app = web.Application(client_max_size=1, middlewares=[self._guarded])
        app.router.add_get('/live', self._live)
        for path in self._files:
            app.router.add_get(path, self._file)
        return web.AppRunner(
            app,
            access_log=None,
            logger=SILENT,
            shutdown_timeout=0.1,
            keepalive_timeout=15.0,
            lingering_time=0.0,
            max_line_size=LONGEST_LINE_BYTES,
            max_field_size=LONGEST_LINE_BYTES,
        )

    def _drop_viewers(self) -> None:
        for viewer in tuple(self._viewers):
            viewer.drop()

    async def _listen(self, runner: web.AppRunner) -> None:
        ports = range(self.port, self.port + PORTS_TRIED) if self.port else (0,)
        for port in ports:
            try:
                await web.TCPSite(runner, self._address, port).start()
            except OSError as error:
                if error.errno != errno.EADDRINUSE or port == ports[-1]:
                    raise
            else:
                self.port = runner.addresses[0][1]
                return

    async def _beat(self) -> None:
        while True:
            await asyncio.sleep(BEAT_S)
            self._tell(Update.of('beat', None))

    def _publish(self, updates: tuple[Update, ...]) -> None:
        for update in updates:
            if self._board.take(update):
                self._tell(update)

    def _tell(self, update: Update) -> None:
        text = update.text
        for viewer in self._viewers:
            viewer.tell(text)

    # -- requests ------------------------------------------------------------------------------

    @web.middleware
    async def _guarded(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse strangers; say on every answer what a browser must not do with it."""
        refusal = self._access.refusal(request.headers)
        try:
            if refusal:
                raise web.HTTPForbidden(text=f'{refusal}\n')
            response = await self._to_the_known(request, handler)
        except web.HTTPException as error:
            response = web.Response(status=error.status, text=error.text, headers=error.headers)
        if not response.prepared:
            response.headers.update(HEADERS)
        return response

    async def _to_the_known(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Answer who has the token: as a cookie, or once in the address, which makes it one."""
        cookie = f'page_{self.port}'
        shown = request.query.get('token')
        if shown is not None and self._access.is_known(shown):
            answer = web.Response(status=303, headers={'Location': '/'})
            answer.set_cookie(cookie, shown, path='/', httponly=True, samesite='Strict')
            return answer
        if shown is not None or not self._access.is_known(request.cookies.get(cookie, '')):
            raise web.HTTPUnauthorized(text='open the page by the address that has the token\n')
        return await handler(request)

    async def _file(self, request: web.Request) -> web.Response:
        kind, content = self._files[request.path]
        return web.Response(body=content, content_type=kind, charset='utf-8')

    async def _live(self, request: web.Request) -> web.StreamResponse:
        if len(self._viewers) >= MOST_VIEWERS:
            raise web.HTTPServiceUnavailable(text=f'{MOST_VIEWERS} browsers look already\n')
        # Nothing that a browser sends is wanted: the first message ends the connection.
        socket = web.WebSocketResponse(
            compress=False, max_msg_size=LONGEST_LINE_BYTES, heartbeat=3 * BEAT_S
        )
        if not socket.can_prepare(request):
            raise web.HTTPBadRequest(text='a web socket is expected\n')
        await socket.prepare(request)
        viewer = Viewer(socket, request, self._board.all())
        self._viewers.add(viewer)
        sending = asyncio.create_task(viewer.send())
        try:
            message = await socket.receive()
            if message.type in (WSMsgType.TEXT, WSMsgType.BINARY):
                await socket.close(code=1008)
        finally:
            self._viewers.discard(viewer)
            self.n_slow += viewer.was_slow
            sending.cancel()
            # To its end: a task that outlives its loop is ended without one.
            await asyncio.wait([sending])
        return socket
