"""Robot Web Services over HTTP (1.0) or HTTPS (2.0), the resources a client needs to run programs.

References
----------
ABB, Application manual Robot Web Services, 3HAC050973-001 (1.0, RobotWare 6) and
3HAC073675-001 (2.0, RobotWare 7).
"""

from collections.abc import Awaitable, Callable
from contextvars import ContextVar
import ssl
from typing import Any

from aiohttp import web

from abb_emulator.rapid import LARGEST_BYTES
from abb_emulator.rws.http_login import Basic, Digest, Login
from abb_emulator.rws.rws_dialect import (
    action_path_1,
    action_path_2,
    check_headers_2,
    shown_path_1,
)
from abb_emulator.rws.rws_events import Subscriptions
from abb_emulator.rws.rws_pages import (
    HAL,
    JSON,
    json_1,
    json_2,
    linked_page,
    page,
    refusal_json,
    refusal_page,
    XHTML,
    XHTML_2,
)
from abb_emulator.rws.rws_refusal import NO_RESOURCE, RwsRefusalError
from abb_emulator.rws.rws_resources import Shown
from abb_emulator.rws.rws_sessions import COOKIE, SECOND_COOKIE, Session, Sessions
from abb_emulator.rws.rws_station import Station
from abb_emulator.rws.self_signed import server_context
from modal_core.errors import BridgeError
from modal_core.nodes.threaded_server import ThreadedServer

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]
PROTOCOLS = {1: 'robapi2_subscription', 2: 'rws_subscription'}
START_S = 5.0
_SESSION: ContextVar[Session] = ContextVar('session')
"""Of the request that is being answered."""


class RwsServer:
    """Serves one station from a thread of its own.

    Parameters
    ----------
    station : Station
        Shown and operated.
    address : str
        Interface to listen on.
    port : int
        TCP port; 0 takes a free one.
    user, password : str
        The one account; the defaults of the node are the controller's own.
    version : int
        1: HTTP and digest authentication; 2: HTTPS with a certificate made for the purpose.

    Attributes
    ----------
    fingerprint : str
        SHA-256 of the certificate, in hexadecimal; empty without one.
    n_credentials : int
        Requests that came with user and password.

    Raises
    ------
    BridgeError
        The port cannot be used, or no certificate can be made.
    """

    def __init__(
        self,
        station: Station,
        address: str,
        port: int,
        user: str,
        password: str,
        version: int = 1,
    ) -> None:
        self.port, self._modern = port, version == 2
        self._station, self._address = station, address
        self._login: Login = (Basic if self._modern else Digest)(user, password)
        self._context: ssl.SSLContext | None = None
        self.fingerprint, self.n_credentials = '', 0
        if self._modern:
            self._context, self.fingerprint = server_context(address)
        self._sessions = Sessions()
        self._subscriptions = Subscriptions(self._shown_at, PROTOCOLS[version])
        try:
            self._server = ThreadedServer(self._runner(), self._listen, 'rws', START_S)
        except OSError as error:
            raise BridgeError(
                'port cannot be used', where=f'{address}:{port}', found=error.strerror
            ) from error

    def close(self) -> None:
        """Stop serving."""
        self._server.close()

    # -- serving -------------------------------------------------------------------------------

    def _runner(self) -> web.AppRunner:
        app = web.Application(client_max_size=LARGEST_BYTES, middlewares=[self._guarded])
        for method, path, handler in (
            ('GET', '/fileservice/{path:.+}', self._get_file),
            ('PUT', '/fileservice/{path:.+}', self._put_file),
            ('DELETE', '/fileservice/{path:.+}', self._delete_file),
            ('POST', '/subscription', self._subscribe),
            ('DELETE', r'/subscription/{number:\d+}', self._unsubscribe),
            ('GET', r'/poll/{number:\d+}', self._poll),
            ('GET', '/logout', self._log_out),
            ('GET', '/{path:.*}', self._show),
            ('POST', '/{path:.*}', self._act),
        ):
            app.router.add_route(method, path, handler)
        return web.AppRunner(app, access_log=None, shutdown_timeout=0.1)

    async def _listen(self, runner: web.AppRunner) -> None:
        await web.TCPSite(runner, self._address, self.port, ssl_context=self._context).start()
        self.port = runner.addresses[0][1]

    @web.middleware
    async def _guarded(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Let in who has a session or the password; one answer for every refusal."""
        session = self._sessions.find(request.cookies.get(COOKIE, ''))
        known = session is not None
        try:
            if session is None:
                session = self._welcome(request)
            if session is None:
                challenge = {'WWW-Authenticate': self._login.challenge()}
                return web.Response(status=401, text='Unauthorized', headers=challenge)
            _SESSION.set(session)
            if self._modern:
                check_headers_2(request.method, request.path, request.headers)
            response = await handler(request)
        except RwsRefusalError as refusal:
            response = self._refusal(request, refusal)
        except web.HTTPException as error:
            found = RwsRefusalError(error.reason, error.status, NO_RESOURCE)
            response = self._refusal(request, found)
        if session is not None and not known and not response.prepared:
            self._set_cookies(response, session)
        return response

    def _welcome(self, request: web.Request) -> Session | None:
        """Return a session of who knows the password."""
        header = request.headers.get('Authorization', '')
        self.n_credentials += bool(header)
        if not self._login.accepts(header, request.method, request.raw_path):
            return None
        # A websocket may come with the second cookie alone.
        number = request.cookies.get(SECOND_COOKIE, '')
        return self._sessions.numbered(number) or self._sessions.make()

    def _set_cookies(self, response: web.StreamResponse, session: Session) -> None:
        for name, value in ((COOKIE, session.key), (SECOND_COOKIE, str(session.number))):
            response.set_cookie(
                name, value, path='/', httponly=True, samesite='Strict', secure=self._modern
            )

    # -- requests ------------------------------------------------------------------------------

    async def _show(self, request: web.Request) -> web.StreamResponse:
        path = request.path if self._modern else shown_path_1(request.path, request.query)
        return self._page(request, self._station.shown(path.rstrip('/'), self._modern))

    async def _act(self, request: web.Request) -> web.StreamResponse:
        form = dict(await _posted(request))
        form |= {name: request.query[name] for name in ('mastership',) if name in request.query}
        path_of = action_path_2 if self._modern else action_path_1
        shown = self._station.act(
            path_of(request.path, request.query), form, _SESSION.get(), self._sessions,
            self._modern,
        )  # fmt: skip
        return web.Response(status=204) if shown is None else self._page(request, shown)

    async def _get_file(self, request: web.Request) -> web.StreamResponse:
        found = self._station.file(request.match_info['path'].rstrip('/'))
        if isinstance(found, Shown):
            return self._page(request, found)
        return web.Response(body=found, content_type='application/octet-stream')

    async def _put_file(self, request: web.Request) -> web.StreamResponse:
        new = self._station.files.store(request.match_info['path'], await request.read())
        return self._written(linked_page({'self': request.path}), 201 if new else 200)

    async def _delete_file(self, request: web.Request) -> web.StreamResponse:
        self._station.files.remove(request.match_info['path'])
        return web.Response(status=204)

    async def _subscribe(self, request: web.Request) -> web.StreamResponse:
        posted = await _posted(request)
        resources = [value for name, value in posted if name == 'resources']
        number = self._subscriptions.add(dict(posted), resources)
        scheme = 'wss' if self._modern else 'ws'
        place = f'{scheme}://{request.host}/poll/{number}'
        links = {'group': f'subscription/{number}', 'self': place}
        response = self._written(linked_page(links), 201)
        response.headers['Location'] = place
        return response

    async def _unsubscribe(self, request: web.Request) -> web.StreamResponse:
        self._subscriptions.remove(int(request.match_info['number']))
        return web.Response(status=200)

    async def _poll(self, request: web.Request) -> web.StreamResponse:
        return await self._subscriptions.tell(int(request.match_info['number']), request)

    async def _log_out(self, _: web.Request) -> web.StreamResponse:
        self._sessions.end(_SESSION.get())
        return self._written(linked_page({}), 200)

    def _shown_at(self, path: str) -> Shown:
        found = path if self._modern else shown_path_1(path, {})
        return self._station.shown(found, self._modern)

    # -- answers -------------------------------------------------------------------------------

    def _page(self, request: web.Request, shown: Shown) -> web.Response:
        base = f'{request.url.origin()}{request.path.rsplit("/", 1)[0]}/'
        if self._wants_json(request):
            return self._json((json_2 if self._modern else json_1)(base, shown), 200)
        return self._written(page(base, shown), 200)

    def _refusal(self, request: web.Request, refusal: RwsRefusalError) -> web.Response:
        if self._wants_json(request):
            return self._json(refusal_json(refusal, self._modern), refusal.status)
        return self._written(refusal_page(refusal), refusal.status)

    def _wants_json(self, request: web.Request) -> bool:
        if self._modern:
            return 'json' in request.headers.get('Accept', '')
        return request.query.get('json') == '1'

    def _json(self, text: str, status: int) -> web.Response:
        return _response(text, status, HAL if self._modern else JSON)

    def _written(self, text: str, status: int) -> web.Response:
        return _response(text, status, XHTML_2 if self._modern else XHTML)


async def _posted(request: web.Request) -> list[tuple[str, str]]:
    """Return the fields of the form of a request, as they come: a name may come again."""
    try:
        return [(name, str(value)) for name, value in (await request.post()).items()]
    except (ValueError, LookupError) as error:
        # Bytes that are no text, parts without their boundary, a charset nobody knows.
        raise RwsRefusalError('the body is not a form') from error


def _response(text: str, status: int, media: str) -> web.Response:
    """Return an answer whose media type is exactly this: clients compare it whole."""
    headers: dict[str, Any] = {'Content-Type': media}
    return web.Response(body=text.encode(), status=status, headers=headers)
