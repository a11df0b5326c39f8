"""Robot Web Services byte by byte: media types, status codes, sessions, mastership, events."""

import asyncio
import base64
import http.client
import json
import ssl
import time
from urllib.parse import urlencode

import aiohttp
import pytest

from abb_emulator.rws.rws_sessions import LONGEST_IDLE_S, MOST_SESSIONS, Sessions
from modal_core.errors import BridgeError
from test.support.rws_cell import MODULE, PASSWORD, RwsCell, USER
from test.support.web_client import WebClient

FORM = 'application/x-www-form-urlencoded;v=2.0'
HAL, XHTML = 'application/hal+json;v=2.0', 'application/xhtml+xml;v=2.0'


@pytest.fixture
def cell(model, start_deg):
    made = RwsCell(model, start_deg, (1, 2))
    yield made
    made.close()


class Raw:
    """A client of version 2.0 that sends exactly what it is told; one session."""

    def __init__(self, cell):
        self.port, self.cookies = cell.servers[2].port, {}
        self.context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        self.context.check_hostname, self.context.verify_mode = False, ssl.CERT_NONE
        word = base64.b64encode(f'{USER}:{PASSWORD}'.encode()).decode()
        self.login = {'Authorization': f'Basic {word}'}

    def ask(self, method, path, form=None, **headers):
        wire = http.client.HTTPSConnection('127.0.0.1', self.port, context=self.context)
        named = {name.replace('_', '-'): value for name, value in headers.items()}
        cookie = '; '.join(f'{name}={value}' for name, value in self.cookies.items())
        data = urlencode(form) if isinstance(form, dict) else form
        wire.request(method, path, data, {**self.login, 'Cookie': cookie, **named})
        answer = wire.getresponse()
        body = answer.read()
        for item in answer.headers.get_all('Set-Cookie', []):
            name, _, value = item.split(';')[0].partition('=')
            self.cookies[name] = value
        wire.close()
        return answer, body

    def post(self, path, form=None):
        return self.ask('POST', path, form or {}, Content_Type=FORM, Accept=HAL)[0].status


def test_media_types_of_version_1_are_exactly_what_clients_compare_with(cell):
    client = WebClient(cell.servers[1].port)
    for path, kind in (
        ('/rw/rapid/tasks?json=1', 'application/json'),
        ('/rw/rapid/tasks', 'application/xhtml+xml'),
        ('/rw/nothing?json=1', 'application/json'),
        ('/rw/elog/0/?lang=en&json=1', 'application/json'),
    ):
        client.ask('GET', path)
        assert client.headers['Content-Type'] == kind
    client.ask('PUT', '/fileservice/$HOME/x.mod', MODULE.encode())
    assert client.ask('POST', '/rw/rapid/tasks/T_ROB1?action=loadmod', {
        'modulepath': '$HOME/x.mod'})[0] == 200  # fmt: skip
    assert client.headers['Content-Type'] == 'application/xhtml+xml'
    assert {cookie.name for cookie in client.cookies} == {'-http-session-', 'ABBCX'}


def test_version_2_takes_nothing_without_its_media_types(cell):
    raw = Raw(cell)
    for accept, status in ((HAL, 200), (XHTML, 200), ('*/*', 200), ('application/json', 406)):
        answer, _ = raw.ask('GET', '/rw/panel/opmode', Accept=accept)
        assert answer.status == status
    stop = '/rw/rapid/execution/stop'
    assert raw.ask('POST', stop, '', Content_Type=FORM)[0].status == 204
    plain = 'application/x-www-form-urlencoded'
    assert raw.ask('POST', stop, '', Content_Type=plain)[0].status == 415
    assert raw.ask('POST', stop, '')[0].status == 415
    place = '/fileservice/$HOME/x.mod'
    assert raw.ask('PUT', place, MODULE, Content_Type='text/plain')[0].status == 415
    assert raw.ask('PUT', place, MODULE, Content_Type='text/plain;v=2.0')[0].status == 201
    assert raw.ask('GET', '/fileservice/HOME/x.mod')[1] == MODULE.encode()
    assert (
        raw.ask('POST', '/rw/rapid/execution?action=stop', '', Content_Type=FORM)[0].status == 405
    )
    assert 'Basic' in Raw(cell).ask('GET', '/rw', Authorization='')[0].headers['WWW-Authenticate']


def test_json_of_version_2_is_hal(cell):
    raw = Raw(cell)
    tasks = json.loads(raw.ask('GET', '/rw/rapid/tasks', Accept=HAL)[1])
    assert tasks['_embedded']['resources'][0]['type'] == 'normal'
    mode = json.loads(raw.ask('GET', '/rw/panel/opmode', Accept=HAL)[1])
    assert (mode['state'][0]['opmode'], mode['status']['code']) == ('AUTO', 294912)
    missing = raw.ask('GET', '/rw/rapid/tasks/T_ROB2', Accept=HAL)
    assert missing[0].status == 404
    assert json.loads(missing[1])['status']['code'] < 0
    assert raw.ask('GET', '/rw/panel/ctrlstate', Accept=HAL)[0].status == 404


def test_controller_and_unit_are_described_as_drivers_ask_at_their_start(cell):
    client, raw = WebClient(cell.servers[1].port), Raw(cell)
    for path, kind, field, value in (
        ('/ctrl/identity', 'ctrl-identity-info', 'ctrl-type', 'Virtual Controller'),
        ('/ctrl', 'ctrl-identity-info-li', 'ctrl-type', 'Virtual Controller'),
        ('/ctrl/clock', 'ctrl-clock-info', 'datetime', None),
        ('/rw/motionsystem/mechunits/ROB_1', 'ms-mechunit', 'type', 'TCPRobot'),
        ('/rw/motionsystem/mechunits/ROB_1', 'ms-mechunit', 'task-name', 'T_ROB1'),
    ):
        old = client.state(path)
        answer = json.loads(raw.ask('GET', path, Accept=HAL)[1])
        new = (answer.get('state') or answer['_embedded']['resources'])[0]
        for state in (old, new):
            assert state['_type'] == kind
            assert state[field] == value or value is None
    assert time.strptime(client.state('/ctrl/clock')['datetime'], '%Y-%m-%d T %H:%M:%S')


def test_a_change_of_programs_needs_the_mastership_in_version_2(cell):
    first, second = Raw(cell), Raw(cell)
    cell.task.load(MODULE)
    reset = '/rw/rapid/execution/resetpp'
    assert first.post(reset) == 403
    assert first.post('/rw/mastership/edit/request') == 204
    assert first.post(reset) == 204
    assert second.post('/rw/mastership/edit/request') == 403
    assert second.post(f'{reset}?mastership=implicit') == 403
    assert second.post('/rw/mastership/edit/release') == 403
    assert first.post('/rw/mastership/edit/release') == 204
    assert second.post(f'{reset}?mastership=implicit') == 204
    assert second.post('/rw/mastership/rapid/request') == 404
    assert second.post('/rw/mastership/edit/request') == 204
    assert second.ask('GET', '/logout')[0].status == 200
    assert first.post('/rw/mastership/edit/request') == 204


def test_the_mastership_of_another_client_counts_in_version_1_too(cell):
    first, second = (WebClient(cell.servers[1].port) for _ in range(2))
    cell.task.load(MODULE)
    assert first.ask('POST', '/rw/mastership/rapid?action=request')[0] == 204
    assert second.ask('POST', '/rw/rapid/execution?action=resetpp')[0] == 403
    assert first.ask('POST', '/rw/mastership/rapid?action=release')[0] == 204
    assert second.ask('POST', '/rw/rapid/execution?action=resetpp')[0] == 204


def test_a_client_without_cookies_uses_all_sessions_up_and_idle_ones_end():
    time_s = [0.0]
    sessions = Sessions(lambda: time_s[0])
    kept = sessions.make()
    for _ in range(MOST_SESSIONS - 1):
        sessions.make()
    with pytest.raises(BridgeError, match='too many sessions'):
        sessions.make()
    time_s[0] = LONGEST_IDLE_S - 1.0
    assert sessions.find(kept.key) is kept
    time_s[0] = LONGEST_IDLE_S + 1.0
    sessions.take(sessions.make(), 'edit')
    assert sessions.find(kept.key) is kept


def test_version_2_tells_changes_by_websocket(cell):
    async def listen():
        word = base64.b64encode(f'{USER}:{PASSWORD}'.encode()).decode()
        login = {'Authorization': f'Basic {word}'}
        jar = aiohttp.CookieJar(unsafe=True)
        base = f'https://{cell.address(2)}'
        async with aiohttp.ClientSession(headers=login, cookie_jar=jar) as client:
            form = {'resources': '1', '1': '/rw/panel/ctrl-state', '1-p': '1'}
            made = await client.post(
                f'{base}/subscription', data=urlencode(form), ssl=False,
                headers={'Content-Type': FORM, 'Accept': XHTML},
            )  # fmt: skip
            assert made.status == 201
            place = made.headers['Location']
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await client.ws_connect(place, ssl=False, protocols=('robapi2_subscription',))
            async with client.ws_connect(
                place, ssl=False, protocols=('rws_subscription',)
            ) as wire:
                first = await wire.receive_str(timeout=5)
                cell.controller.emergency_stop()
                return first, await wire.receive_str(timeout=5)

    first, second = asyncio.run(listen())
    assert '<span class="ctrlstate">motoron</span>' in first
    assert '<span class="ctrlstate">emergencystop</span>' in second
