"""Robot Web Services over real HTTP, by the digest client of the standard library."""

import json
import socket
import threading
import urllib.error
import urllib.parse
import urllib.request
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from abb_emulator.cell import CellSettings, MotorSide
from abb_emulator.egm.guidance_law import GuidanceSettings
from abb_emulator.rapid.program_task import ProgramTask
from abb_emulator.rws.rws_server import RwsServer
from abb_emulator.rws.rws_station import Station
from test.support.web_client import WebClient

MODULE = """MODULE Small
  CONST jointtarget jA:=[[2,45,-10,90,-90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveAbsJ jA\\NoEOffs,v50,fine,tool0;
  ENDPROC
ENDMODULE
"""


class Cell:
    def __init__(self, model, start_deg):
        self.motors = MotorSide(model, start_deg, None, CellSettings(), 0.0)
        self.controller = self.motors.controller
        task = ProgramTask(self.controller, GuidanceSettings(), np.random.default_rng(1))
        station = Station(self.controller, task, threading.Lock())
        self.server = RwsServer(station, '127.0.0.1', 0, 'Default User', 'robotics')


@pytest.fixture
def cell(model, start_deg):
    made = Cell(model, start_deg)
    yield made
    made.server.close()


@pytest.fixture
def client(cell):
    return WebClient(cell.server.port)


LOAD = '/rw/rapid/tasks/T_ROB1?action=loadmod'
EXECUTION = '/rw/rapid/execution'


def upload(client, text=MODULE, name='$HOME/x.mod'):
    return client.ask('PUT', f'/fileservice/{name}', text.encode())[0]


def test_upload_load_start_run_and_read_the_joints(cell, client):
    assert upload(client) == 201
    assert upload(client) == 200
    assert client.ask('POST', LOAD, {'modulepath': '$HOME/x.mod', 'replace': 'true'})[0] == 200
    assert client.ask('POST', f'{EXECUTION}?action=resetpp')[0] == 204
    assert client.state(EXECUTION)['ctrlexecstate'] == 'stopped'
    start = {'regain': 'continue', 'execmode': 'continue', 'cycle': 'once', 'condition': 'none'}
    assert client.ask('POST', f'{EXECUTION}?action=start', start)[0] == 204
    assert client.state(EXECUTION)['ctrlexecstate'] == 'running'
    assert client.ask('POST', f'{EXECUTION}?action=resetpp')[0] == 403
    for _ in range(600):
        cell.motors.cycle()
    assert client.state(EXECUTION)['ctrlexecstate'] == 'stopped'
    joints = client.state('/rw/motionsystem/mechunits/ROB_1/jointtarget')
    found = [float(joints[f'rax_{axis}']) for axis in range(1, 7)]
    np.testing.assert_allclose(found, [2, 45, -10, 90, -90, 0], atol=1e-2)


def test_stop_and_panel(cell, client):
    upload(client)
    client.ask('POST', LOAD, {'modulepath': 'HOME:/x.mod'})
    client.ask('POST', f'{EXECUTION}?action=start')
    cell.motors.cycle()
    assert client.ask('POST', f'{EXECUTION}?action=stop', {'stopmode': 'stop'})[0] == 204
    assert client.state(EXECUTION)['ctrlexecstate'] == 'stopped'
    assert client.state('/rw/panel/opmode')['opmode'] == 'AUTO'
    assert client.state('/rw/panel/speedratio')['speedratio'] == '100'
    assert client.state('/rw/panel/ctrlstate')['ctrlstate'] == 'motoron'
    cell.controller.emergency_stop()
    assert client.state('/rw/panel/ctrlstate')['ctrlstate'] == 'emergencystop'
    assert client.ask('POST', f'{EXECUTION}?action=start')[0] == 403
    cell.controller.release_emergency_stop()
    assert client.state('/rw/panel/ctrlstate')['ctrlstate'] == 'motoroff'
    cell.controller.set_automatic(False)
    assert client.state('/rw/panel/opmode')['opmode'] == 'MANR'


@pytest.mark.parametrize(
    ('what', 'field', 'before', 'wanted'),
    [
        ('ctrlstate', 'ctrl-state', 'motoron', 'motoroff'),
        ('speedratio', 'speed-ratio', '100', '50'),
    ],
)
def test_the_panel_is_set_by_its_own_action_only(client, what, field, before, wanted):
    path = f'/rw/panel/{what}'
    for action in ('', '?action=start', '?action=set'):
        assert client.ask('POST', path + action, {field: wanted})[0] == 400
        assert client.state(path)[what] == before
    assert client.ask('POST', f'{path}?action=set{what}', {field: 'rubbish'})[0] == 400
    assert client.ask('POST', f'{path}?action=set{what}', {field: wanted})[0] == 204
    assert client.state(path)[what] == wanted


def test_without_json_the_answer_is_xhtml(client):
    status, body = client.ask('GET', EXECUTION)
    tree = ElementTree.fromstring(body)
    spans = {e.get('class'): e.text for e in tree.iter('{http://www.w3.org/1999/xhtml}span')}
    assert (status, spans['ctrlexecstate']) == (200, 'stopped')


def test_the_session_cookie_saves_the_password(cell, client):
    assert client.ask('GET', EXECUTION)[0] == 200
    plain = urllib.request.build_opener(
        urllib.request.ProxyHandler({}), urllib.request.HTTPCookieProcessor(client.cookies)
    )
    with plain.open(client.base + EXECUTION, timeout=10) as answer:
        assert answer.status == 200


def test_nobody_gets_in_without_the_password(cell):
    wrong = WebClient(cell.server.port, 'wrong')
    assert wrong.ask('POST', f'{EXECUTION}?action=start')[0] == 401
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    with pytest.raises(urllib.error.HTTPError) as caught:
        opener.open(f'{wrong.base}{EXECUTION}', timeout=10)
    assert caught.value.code == 401
    assert 'Digest' in caught.value.headers['WWW-Authenticate']
    assert not cell.controller.running


@pytest.mark.parametrize(
    'name', ['$HOME/../x.mod', '$HOME/a/b.mod', 'etc/passwd', '$HOME/%2e%2e%2fx', '$HOME/']
)
def test_files_stay_in_home(client, name):
    assert upload(client, name=name) in (400, 404)


def test_a_module_it_does_not_execute_is_refused_by_line(client):
    upload(client, MODULE.replace('MoveAbsJ', 'MoveJ'))
    status, body = client.ask('POST', f'{LOAD}&json=1', {'modulepath': '$HOME/x.mod'})
    assert status == 400
    assert 'line 4' in json.loads(body)['_embedded']['status']['msg']
    assert client.ask('POST', f'{EXECUTION}?action=start')[0] == 403


def test_too_large_or_malformed_requests_end_in_one_answer(cell, client):
    assert client.ask('PUT', '/fileservice/$HOME/x.mod', b'x' * 8_000_001)[0] == 413
    assert client.ask('GET', '/rw/nothing')[0] == 404
    assert client.ask('POST', f'{EXECUTION}?action=dance')[0] == 400
    with socket.create_connection(('127.0.0.1', cell.server.port), 10) as raw:
        raw.sendall(b'GET / HTTP/9.9\r\n\x00\xff\r\n\r\n')
        assert raw.recv(4096).startswith(b'HTTP/1.')
    assert client.state(EXECUTION)['ctrlexecstate'] == 'stopped'


FORM = 'application/x-www-form-urlencoded'


@pytest.mark.parametrize(
    ('path', 'media', 'body'),
    [
        ('/rw/rapid/execution?action=stop', FORM, b'\xfa\xbe\xae=1'),
        ('/rw/rapid/execution?action=stop', 'multipart/form-data; boundary=x', b'no boundary'),
        ('/rw/rapid/execution?action=stop', f'{FORM}; charset=klingon', b'a=1'),
        ('/subscription', 'multipart/form-data', b''),
        ('/subscription', FORM, b'1-p=1'),
    ],
)
def test_a_body_that_is_no_form_is_refused_and_named(cell, client, caplog, path, media, body):
    client.ask('GET', '/rw/system')
    request = urllib.request.Request(client.base + path, body, method='POST')
    request.add_header('Content-Type', media)
    with pytest.raises(urllib.error.HTTPError) as caught:
        client.opener.open(request, timeout=10)
    assert caught.value.code == 400
    assert not caplog.records, 'no traceback in the log'
