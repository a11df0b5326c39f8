"""The page's server by itself: who may look, what is refused, who is let go."""

import asyncio
import json
import socket
import time

import aiohttp
import pytest

from modal_core.errors import SettingsError
from modal_dashboard.screens import Board, Update
from modal_dashboard.server import Access, host_of, PageServer

TOKEN = 'a-token-of-sixteen'


@pytest.fixture
def serve():
    servers = []

    def make(access=None, port=0):
        servers.append(PageServer('127.0.0.1', port, access or Access()))
        return servers[-1]

    yield make
    for server in servers:
        server.close()


def ask(server, method='GET', path='/', cookies=None, **headers):
    """Return status, headers and text of an answer."""

    async def run():
        url = f'http://127.0.0.1:{server.port}{path}'
        names = {name.replace('_', '-'): value for name, value in headers.items()}
        async with (
            aiohttp.ClientSession(cookies=cookies) as session,
            session.request(method, url, headers=names, allow_redirects=False) as answer,
        ):
            return answer.status, dict(answer.headers), await answer.text()

    return asyncio.run(run())


@pytest.mark.parametrize(
    ('headers', 'status'),
    [
        ({}, 200),
        ({'Host': 'localhost:1'}, 200),
        ({'Host': '192.168.0.7'}, 200),
        ({'Host': '[::1]:8470'}, 200),
        ({'Host': 'evil.example'}, 403),
        ({'Host': 'localhost.evil.example'}, 403),
        ({'Host': '127.0.0.1.evil.example:80'}, 403),
        ({'Host': 'robot.hall'}, 200),
        ({'Host': '['}, 403),
        ({'Origin': 'http://evil.example'}, 403),
        ({'Origin': 'null'}, 403),
        ({'Origin': 'http://['}, 403),
        ({'Origin': 'http://127.0.0.1:1'}, 403),
        ({'Sec_Fetch_Site': 'cross-site'}, 403),
    ],
)
@pytest.mark.parametrize('path', ['/', '/live.js', '/live'])
def test_strangers_are_refused(serve, headers, status, path):
    server = serve(Access(names=('robot.hall',)))
    # The web socket's address tells those who may ask that it wants a web socket.
    expected = 400 if path == '/live' and status == 200 else status
    assert ask(server, path=path, **headers)[0] == expected


@pytest.mark.parametrize('method', ['POST', 'PUT', 'PATCH', 'DELETE', 'OPTIONS', 'TRACE'])
def test_there_is_nothing_to_write_to(serve, method):
    server = serve()
    for path in ('/', '/live', '/live.js'):
        assert ask(server, method, path)[0] == 405


@pytest.mark.parametrize(
    'path',
    ['/etc/passwd', '/../setup.py', '/%2e%2e/%2e%2e/etc', '/static/', '//', '/live/'],
)
def test_three_files_are_all_there_is(serve, path):
    assert ask(serve(), path=path)[0] == 404


def test_every_answer_forbids_all_but_the_page_s_own(serve):
    server = serve()
    for path, headers in (('/', {}), ('/none', {}), ('/', {'Host': 'evil.example'})):
        _, answer, _ = ask(server, path=path, **headers)
        policy = answer['Content-Security-Policy']
        assert "default-src 'none'" in policy and 'unsafe' not in policy
        assert answer['X-Content-Type-Options'] == 'nosniff'


@pytest.mark.parametrize('what', ['line', 'header', 'body'])
def test_large_requests_are_refused(serve, what):
    server = serve()
    line = f'GET /{"x" * 9000 if what == "line" else ""} HTTP/1.1\r\n'
    header = f'X: {"x" * 9000}\r\n' if what == 'header' else ''
    body = 'Content-Length: 100000000\r\n' if what == 'body' else ''
    with socket.create_connection(('127.0.0.1', server.port), 10.0) as connection:
        connection.sendall(f'{line}Host: 127.0.0.1\r\n{header}{body}\r\n'.encode())
        answer = connection.recv(100).decode()
        if what == 'body':
            # It is answered and cut off, never read.
            assert answer.startswith('HTTP/1.1 200')
            connection.settimeout(10.0)
            while connection.recv(1 << 20):
                pass
        else:
            assert ' 400 ' in answer


def test_the_token_opens_once_and_is_a_cookie_then(serve):
    server = serve(Access(TOKEN))
    assert ask(server)[0] == 401
    assert ask(server, path='/live')[0] == 401
    assert ask(server, path='/?token=wrong')[0] == 401
    assert ask(server, cookies={f'page_{server.port}': 'wrong'})[0] == 401
    for strange in ('?token=%ff%fe', '?token=', '?token=%C3%A9&token='):
        assert ask(server, path=f'/{strange}')[0] == 401
    raw = f'GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: page_{server.port}='.encode()
    with socket.create_connection(('127.0.0.1', server.port), 10.0) as connection:
        connection.sendall(raw + b'\xff\xfe\r\n\r\n')
        assert b' 401 ' in connection.recv(100)
    status, headers, _ = ask(server, path=f'/?token={TOKEN}')
    assert (status, headers['Location']) == (303, '/')
    assert 'HttpOnly' in headers['Set-Cookie'] and 'SameSite=Strict' in headers['Set-Cookie']
    assert ask(server, cookies={f'page_{server.port}': TOKEN})[0] == 200


def heard(server, n_messages, send=None):
    """Return messages that one client hears, and the code its connection was closed with."""

    async def run():
        url = f'ws://127.0.0.1:{server.port}/live'
        async with aiohttp.ClientSession() as session, session.ws_connect(url) as live:
            if send is not None:
                await live.send_str(send)
            messages = []
            while len(messages) < n_messages:
                message = await live.receive(10.0)
                if message.type != aiohttp.WSMsgType.TEXT:
                    return messages, live.close_code
                messages.append(json.loads(message.data))
            return messages, None

    return asyncio.run(run())


def test_who_comes_late_is_told_the_last_of_everything(serve):
    server = serve()
    for number in range(3):
        server.send(Update.of('window', {'index': number}), Update.of('track', number))
    time.sleep(0.1)
    messages, _ = heard(server, 3)
    assert messages == [
        {'kind': 'window', 'data': {'index': 2}},
        {'kind': 'tracks', 'data': [0, 1, 2]},
        {'kind': 'logs', 'data': []},
    ]


def test_what_says_nothing_new_is_not_said_again(serve):
    server = serve()
    server.send(Update.of('alarms', 1))

    async def run():
        url = f'http://127.0.0.1:{server.port}/live'
        async with aiohttp.ClientSession() as session, session.ws_connect(url) as live:
            for _ in range(3):
                await live.receive(10.0)
            server.send(*(Update.of('alarms', value) for value in (1, 1, 2)))
            return json.loads((await live.receive(10.0)).data)

    assert asyncio.run(run()) == {'kind': 'alarms', 'data': 2}


def test_the_board_is_bounded():
    board = Board()
    for number in range(2000):
        board.take(Update.of('log', number))
        board.take(Update.of('window', number))
    window, tracks, logs = (json.loads(text)['data'] for text in board.all())
    assert (window, tracks, len(logs), logs[-1]) == (1999, [], 300, 1999)


def test_numbers_that_are_none_never_leave():
    with pytest.raises(ValueError, match='JSON'):
        Update.of('window', float('nan'))


def test_who_speaks_is_shown_out(serve):
    assert heard(serve(), 10, send='{"start": true}')[1] == 1008


def test_who_does_not_listen_is_let_go_and_nobody_waits(serve):
    """A client that reads nothing while a hundred megabytes are told to all."""
    server = serve()
    request = (
        f'GET /live HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nUpgrade: websocket\r\n'
        'Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n'
        'Sec-WebSocket-Version: 13\r\n\r\n'
    )
    with socket.create_connection(('127.0.0.1', server.port), 10.0) as deaf:
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.sendall(request.encode())
        until(lambda: server.n_viewers == 1)
        for number in range(100):
            server.send(Update.of('window', {'index': number, 'much': ['x' * 1000] * 1000}))
        until(lambda: server.n_viewers == 0)
    assert server.n_slow == 1
    (window, *_), _ = heard(server, 1)
    assert window['data']['index'] == 99


def test_more_browsers_than_seats(serve):
    server = serve()
    request = (
        f'GET /live HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nUpgrade: websocket\r\n'
        'Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n'
        'Sec-WebSocket-Version: 13\r\n\r\n'
    )
    seated = []
    for _ in range(32):
        seated.append(socket.create_connection(('127.0.0.1', server.port), 10.0))
        seated[-1].sendall(request.encode())
    until(lambda: server.n_viewers == 32)
    assert ask(server, path='/live')[0] == 503
    for connection in seated:
        connection.close()
    until(lambda: server.n_viewers == 0)
    assert len(heard(server, 2)[0]) == 2


def test_a_port_that_is_taken_is_followed_by_the_next(serve):
    first = serve(port=23470)
    second = serve(port=first.port)
    assert first.port < second.port < first.port + 20


@pytest.mark.parametrize(
    ('address', 'host'),
    [
        ('127.0.0.1', '127.0.0.1'),
        ('localhost', 'localhost'),
        ('::1', '[::1]'),
        ('192.168.0.7', '192.168.0.7'),
        ('0.0.0.0', socket.gethostname()),
    ],
)
def test_the_address_it_says_is_one_it_answers_to(address, host):
    assert host_of(address) == host
    assert Access().refusal({'Host': f'{host}:8470'}) == ''


def test_an_address_of_another_machine_is_refused_in_one_line():
    with pytest.raises(SettingsError, match='cannot be served'):
        PageServer('192.0.2.1', 0, Access(TOKEN))


def until(happened, timeout_s=20.0):
    deadline = time.monotonic() + timeout_s
    while not happened():
        assert time.monotonic() < deadline
        time.sleep(0.01)
