"""The client of the controller's web services: what it asks, what it refuses, what it hides."""

import importlib.util
from pathlib import Path
import socket
import threading

import numpy as np
import pytest

from modal_core.errors import BridgeError
from robot_bridge.backends import BackendSettings, make_backend
from robot_bridge.emulator.cell import CellSettings, MotorSide
from robot_bridge.emulator.guidance_law import GuidanceSettings
from robot_bridge.emulator.program_task import ProgramTask
from robot_bridge.emulator.rws_server import RwsServer
from robot_bridge.emulator.rws_station import Station
from robot_bridge.rws_client import RwsClient
from robot_bridge.web_password import SHIPPED, web_password

_spec = importlib.util.spec_from_file_location(
    'web_controller', Path(__file__).with_name('web_controller.py')
)
_module = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_module)
WebController = _module.WebController
USER, PASSWORD = 'Default User', 'a secret word'
MODULE = """MODULE AmaExcitation
  PROC main()
    WaitTime 0.1;
  ENDPROC
ENDMODULE
"""


@pytest.fixture
def web():
    """Return a function that starts a controller's web services."""
    made = []

    def start(**options):
        made.append(WebController(**options))
        return made[-1]

    yield start
    for item in made:
        item.close()


def test_the_emulator_runs_what_is_loaded_and_stops(model, start_deg):
    motors = MotorSide(model, start_deg, None, CellSettings(), 0.0)
    task = ProgramTask(motors.controller, GuidanceSettings(), np.random.default_rng(1))
    station = Station(motors.controller, task, threading.Lock())
    server = RwsServer(station, '127.0.0.1', 0, USER, PASSWORD)
    try:
        client = RwsClient(f'127.0.0.1:{server.port}', USER, PASSWORD)
        client.load('AmaExcitation', MODULE)
        assert not motors.controller.running
        client.run()
        motors.cycle()
        assert motors.controller.running
        client.stop()
        motors.cycle()
        assert not motors.controller.running
        motors.controller.set_automatic(False)
        with pytest.raises(BridgeError, match='MANR'):
            client.check_automatic()
        wrong = RwsClient(f'127.0.0.1:{server.port}', USER, 'another')
        with pytest.raises(BridgeError, match='rws_password_file') as caught:
            wrong.stop()
        assert 'another' not in str(caught.value)
    finally:
        server.close()


def test_what_is_asked_in_which_order(web):
    controller = web()
    client = RwsClient(controller.address, USER, PASSWORD)
    client.load('AmaExcitation', MODULE)
    client.run()
    client.stop()
    assert controller.requests == [
        'GET /rw/panel/opmode?json=1',
        'GET /rw/panel/ctrlstate?json=1',
        'GET /rw/rapid/execution?json=1',
        'PUT /fileservice/$HOME/AmaExcitation.mod',
        'POST /rw/rapid/tasks/T_ROB1?action=loadmod',
        'POST /rw/rapid/execution?action=resetpp',
        'POST /rw/rapid/execution?action=start',
        'POST /rw/rapid/execution?action=stop',
    ]


@pytest.mark.parametrize(
    ('path', 'field', 'value'),
    [
        ('/rw/panel/opmode', 'opmode', 'MANR'),
        ('/rw/panel/opmode', 'opmode', 'MANF'),
        ('/rw/panel/ctrlstate', 'ctrlstate', 'motoroff'),
        ('/rw/panel/ctrlstate', 'ctrlstate', 'guardstop'),
        ('/rw/rapid/execution', 'ctrlexecstate', 'running'),
    ],
)
def test_nothing_is_loaded_unless_the_controller_is_ready(web, path, field, value):
    controller = web(states={path: {field: value}})
    client = RwsClient(controller.address, USER, PASSWORD)
    with pytest.raises(BridgeError, match=value):
        client.load('AmaExcitation', MODULE)
    assert all(item.startswith('GET') for item in controller.requests)


@pytest.mark.parametrize(
    ('status', 'headers'),
    [
        (401, {'WWW-Authenticate': 'Basic realm="validuser@robapi.abb"'}),
        (301, {'Location': 'https://127.0.0.1/rw/panel/opmode'}),
    ],
    ids=['basic', 'https'],
)
def test_web_services_2_are_refused_and_get_no_password(web, status, headers):
    controller = web(answers={'/rw/panel/opmode': (status, headers)})
    client = RwsClient(controller.address, USER, PASSWORD)
    with pytest.raises(BridgeError, match='RobotWare 7') as caught:
        client.check_automatic()
    assert 'pendant' in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1
    assert controller.authorisations == ['']


@pytest.mark.parametrize(
    'address', ['https://192.168.125.1', 'ftp://a', 'a/b', '', 'a:b', 'user:word@host']
)
def test_an_address_that_cannot_be_meant_is_refused_at_once(address):
    with pytest.raises(BridgeError, match='rws_address'):
        RwsClient(address, USER, PASSWORD)


def test_an_unreachable_controller_is_one_line():
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    with pytest.raises(BridgeError, match='cannot be reached') as caught:
        RwsClient(f'127.0.0.1:{port}', USER, PASSWORD).stop()
    assert PASSWORD not in str(caught.value)


def test_the_password_comes_from_the_file_then_the_environment_then_the_shipped_one(
    tmp_path, monkeypatch
):
    monkeypatch.delenv('AMA_RWS_PASSWORD', raising=False)
    assert web_password('') == SHIPPED
    monkeypatch.setenv('AMA_RWS_PASSWORD', 'of the environment')
    assert web_password('') == 'of the environment'
    file = tmp_path / 'password'
    file.write_text(f'{PASSWORD}\nnot this line\n')
    assert web_password(str(file)) == PASSWORD
    for text in ('', '\nsecond'):
        file.write_text(text)
        with pytest.raises(BridgeError, match='first line'):
            web_password(str(file))
    with pytest.raises(BridgeError, match='No such file'):
        web_password(str(tmp_path / 'none'))
    file.write_bytes(b'\xff\xfe')
    with pytest.raises(BridgeError, match='not a text'):
        web_password(str(file))


def test_the_password_is_in_no_text_of_the_settings(model, web):
    settings = BackendSettings(rws_address=web().address, rws_password=PASSWORD, method='rapid')
    assert PASSWORD not in repr(settings) + str(settings)
    assert PASSWORD not in repr(vars(make_backend(settings, model)))
