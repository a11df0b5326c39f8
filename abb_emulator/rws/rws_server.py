"""Robot Web Services 1.0, the few resources a client needs to load and run a program.

HTTP with digest authentication and session cookies; answers in XHTML, or in JSON with ``?json=1``.

References
----------
ABB Robot Web Services 1.0 for RobotWare 6.
"""

import asyncio
from collections import OrderedDict
from collections.abc import Awaitable, Callable
from html import escape
import secrets
import threading

from aiohttp import web

from abb_emulator.rapid import LARGEST_BYTES
from abb_emulator.rws.http_digest import Digest
from abb_emulator.rws.rws_station import Resource, Station
from modal_core.errors import BridgeError

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]
COOKIE = '-http-session-'
MOST_SESSIONS = 70
ERROR_CODE = -1073442809
START_S = 5.0


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

    Raises
    ------
    BridgeError
        The port cannot be used.
    """

    def __init__(
        self, station: Station, address: str, port: int, user: str, password: str
    ) -> None:
        self.port = port
        self._station, self._address = station, address
        self._digest = Digest(user, password)
        self._sessions: OrderedDict[str, None] = OrderedDict()
        self._loop = asyncio.new_event_loop()
        self._failure: OSError | None = None
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._serve, name='rws', daemon=True)
        self._thread.start()
        self._ready.wait(START_S)
        if self._failure is not None:
            raise BridgeError(
                'port cannot be used', where=f'{address}:{port}', found=self._failure.strerror
            ) from self._failure

    def close(self) -> None:
        """Stop serving."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(START_S)

    # -- serving -------------------------------------------------------------------------------

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        app = web.Application(client_max_size=LARGEST_BYTES, middlewares=[self._guarded])
        app.router.add_put('/fileservice/{path:.+}', self._put_file)
        app.router.add_get('/fileservice/{path:.+}', self._get_file)
        app.router.add_post('/rw/rapid/tasks/T_ROB1', self._load)
        app.router.add_post('/rw/rapid/execution', self._execute)
        app.router.add_post('/rw/panel/{what:ctrlstate|speedratio}', self._set_panel)
        app.router.add_post('/rw/mastership{domain:(/.*)?}', self._mastership)
        app.router.add_get('/{path:.*}', self._show)
        runner = web.AppRunner(app, access_log=None)
        try:
            self._loop.run_until_complete(runner.setup())
            site = web.TCPSite(runner, self._address, self.port)
            self._loop.run_until_complete(site.start())
            self.port = runner.addresses[0][1]
        except OSError as error:
            self._failure = error
            self._ready.set()
        else:
            self._ready.set()
            self._loop.run_forever()
        self._loop.run_until_complete(runner.cleanup())
        self._loop.close()

    @web.middleware
    async def _guarded(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Let in who has a session or the password; one line for every refusal."""
        session = request.cookies.get(COOKIE, '')
        header = request.headers.get('Authorization', '')
        known = session in self._sessions
        if not known and not self._digest.accepts(header, request.method, request.raw_path):
            challenge = {'WWW-Authenticate': self._digest.challenge()}
            return web.Response(status=401, text='Unauthorized', headers=challenge)
        try:
            response = await handler(request)
        except BridgeError as error:
            response = _refusal(request, str(error), 400)
        except web.HTTPException as error:
            response = _refusal(request, error.reason, error.status)
        if not known:
            self._remember(response)
        return response

    def _remember(self, response: web.StreamResponse) -> None:
        session = secrets.token_hex(16)
        self._sessions[session] = None
        while len(self._sessions) > MOST_SESSIONS:
            self._sessions.popitem(last=False)
        response.set_cookie(COOKIE, session, path='/', httponly=True, samesite='Strict')

    # -- requests ------------------------------------------------------------------------------

    async def _show(self, request: web.Request) -> web.StreamResponse:
        found = self._station.resource(request.path)
        if found is None:
            raise web.HTTPNotFound
        return _answer(request, found)

    async def _put_file(self, request: web.Request) -> web.StreamResponse:
        new = self._station.store(request.match_info['path'], await request.read())
        return web.Response(status=201 if new else 200)

    async def _get_file(self, request: web.Request) -> web.StreamResponse:
        data = self._station.read(request.match_info['path'])
        if data is None:
            raise web.HTTPNotFound
        return web.Response(body=data)

    async def _load(self, request: web.Request) -> web.StreamResponse:
        form = await request.post()
        action = request.query.get('action', '')
        if action == 'unloadmod':
            self._station.unload(str(form.get('module', '')))
        elif action == 'loadmod':
            self._station.load(str(form.get('modulepath', '')))
        else:
            raise BridgeError('unknown action', found=action[:40])
        return web.Response(status=200)

    async def _execute(self, request: web.Request) -> web.StreamResponse:
        form = await request.post()
        cycle = str(form.get('cycle', 'asis'))
        self._station.execute(request.query.get('action', ''), cycle)
        return web.Response(status=204)

    async def _set_panel(self, request: web.Request) -> web.StreamResponse:
        form, what = await request.post(), request.match_info['what']
        if request.query.get('action') != f'set{what}':
            raise BridgeError('unknown action', found=request.query.get('action', '')[:40])
        if what == 'ctrlstate':
            self._station.set_motors(str(form.get('ctrl-state', '')))
        else:
            self._station.set_speed_ratio(str(form.get('speed-ratio', '')))
        return web.Response(status=204)

    async def _mastership(self, request: web.Request) -> web.StreamResponse:
        """Grant it to everybody: there is one client."""
        await request.post()
        return web.Response(status=204)


def _answer(request: web.Request, found: tuple[Resource, ...]) -> web.Response:
    folder = request.path.rsplit('/', 1)[0]
    base = f'http://{request.host}{folder}/'
    if request.query.get('json') == '1':
        states = [{'_type': one.kind, '_title': one.title, **one.fields} for one in found]
        return web.json_response(
            {'_links': {'base': {'href': base}}, '_embedded': {'_state': states}}
        )
    items = ''.join(
        f'<li class="{one.kind}" title="{one.title}">{_spans(one)}</li>' for one in found
    )
    return _page(base, f'<div class="state"><ul>{items}</ul></div>', 200)


def _spans(one: Resource) -> str:
    return ''.join(
        f'<span class="{name}">{escape(value)}</span>' for name, value in one.fields.items()
    )


def _refusal(request: web.Request, reason: str, status: int) -> web.Response:
    if request.query.get('json') == '1':
        message = {'code': ERROR_CODE, 'msg': reason}
        return web.json_response({'_embedded': {'status': message}}, status=status)
    text = (
        f'<div class="status"><span class="code">{ERROR_CODE}</span>'
        f'<span class="msg">{escape(reason)}</span></div>'
    )
    return _page('', text, status)


def _page(base: str, content: str, status: int) -> web.Response:
    text = (
        '<?xml version="1.0" encoding="UTF-8"?><html xmlns="http://www.w3.org/1999/xhtml">'
        f'<head><title>control</title><base href="{escape(base)}"/></head>'
        f'<body>{content}</body></html>'
    )
    return web.Response(text=text, status=status, content_type='application/xhtml+xml')
