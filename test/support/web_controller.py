"""A controller's web services on the standard library's HTTP server, for tests of the client.

It asks for no password unless told to, keeps every request, and can be held at any of them.
"""

from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
import json
import threading

STATES = {
    '/rw/panel/opmode': {'opmode': 'AUTO'},
    '/rw/panel/ctrlstate': {'ctrlstate': 'motoron'},
    '/rw/rapid/execution': {'ctrlexecstate': 'stopped', 'cycle': 'once'},
    '/rw/rapid/tasks': {'name': 'T_ROB1', 'type': 'norm', 'active': 'On', 'motiontask': 'TRUE'},
    '/rw/motionsystem/mechunits/ROB_1/jointtarget': {
        **{f'rax_{n}': str(v) for n, v in enumerate((0, 45, -10, 90, -90, 0), 1)},
        **{f'eax_{letter}': '9E+09' for letter in 'abcdef'},
    },
}


class WebController:
    """Serves until closed.

    ``requests`` are ``METHOD path?query`` in the order they came. ``hold`` names a part of one
    that waits for ``release``; ``waiting`` is set meanwhile. ``answers`` maps a path to a status
    and headers given instead of the usual answer. What is put is what is loaded and where the
    program pointer stands, unless ``states`` say otherwise; a list there is several states.
    """

    def __init__(self, hold='', answers=None, states=None):
        self.requests, self.authorisations = [], []
        self.hold, self.answers = hold, answers or {}
        self.states = {**STATES, **(states or {})}
        self.waiting, self.release = threading.Event(), threading.Event()
        outer = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = 'HTTP/1.1'

            def log_message(self, *_):
                pass

            def do_any(self):
                outer.take(self)

            do_GET = do_PUT = do_POST = do_any  # noqa: N815

        self.server = ThreadingHTTPServer(('127.0.0.1', 0), Handler)
        self.server.daemon_threads = True
        self.address = f'127.0.0.1:{self.server.server_port}'
        threading.Thread(target=self.server.serve_forever, args=(0.02,), daemon=True).start()

    def take(self, handler):
        body = handler.rfile.read(int(handler.headers.get('Content-Length', 0)))
        if handler.command == 'PUT':
            self._keep(handler.path.rsplit('/', 1)[1].removesuffix('.mod'), body.decode())
        self.requests.append(f'{handler.command} {handler.path}')
        self.authorisations.append(handler.headers.get('Authorization', ''))
        if self.hold and self.hold in handler.path:
            self.waiting.set()
            self.release.wait(60.0)
        path = handler.path.split('?')[0]
        status, headers = self.answers.get(path, (200, {}))
        state = self.states.get(path, {})
        states = state if isinstance(state, list) else [state]
        body = json.dumps({'_embedded': {'_state': states}}).encode()
        handler.send_response(status)
        for name, value in headers.items():
            handler.send_header(name, value)
        handler.send_header('Content-Length', str(len(body)))
        handler.end_headers()
        handler.wfile.write(body)

    def _keep(self, name, text):
        pointer = {'_title': 'progpointer', 'modulemame': name, 'routinename': 'main'}
        self.states.setdefault('/rw/rapid/tasks/T_ROB1/pcp', pointer)
        self.states.setdefault(f'/rw/rapid/modules/{name}', {'module-text': text})

    def posts(self):
        """Return the actions asked for, in order."""
        return [
            item.split('action=')[1]
            for item in list(self.requests)
            if 'action=' in item and 'mastership' not in item
        ]

    def close(self):
        self.release.set()
        self.server.shutdown()
        self.server.server_close()
