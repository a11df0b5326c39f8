"""The client of the controller's web services: what it asks, what it refuses, what it hides."""

import contextlib
from dataclasses import replace
import gzip
import socket
import threading
from urllib.parse import quote

import numpy as np
import pytest

from abb_emulator.cell import CellSettings, MotorSide
from abb_emulator.egm.guidance_law import GuidanceSettings
from abb_emulator.rapid.program_task import ProgramTask
from abb_emulator.rws.rws_server import RwsServer
from abb_emulator.rws.rws_station import Station
from excitation_planner.planner import plan_excitation
from excitation_planner.rapid.rapid import module_name, rapid_module
from excitation_planner.request import PlanRequest
from modal_core.errors import BridgeError
from robot_bridge.backends.backends import BackendSettings, make_backend
from robot_bridge.rws.released_program import ReleasedProgram
from robot_bridge.rws.rws_client import RwsClient
from robot_bridge.rws.web_services import RwsAccess
from robot_bridge.web_password import SHIPPED, web_password

USER, PASSWORD = 'Default User', 'a secret word'
MODULE = """MODULE AmaExcitation_1
  PROC main()
    WaitTime 0.1;
  ENDPROC
ENDMODULE
"""
PROGRAM = ReleasedProgram('AmaExcitation_1', MODULE, (0.0, 45.0, -10.0, 90.0, -90.0, 0.0), 0.05)
JOINT_TARGET = '/rw/motionsystem/mechunits/ROB_1/jointtarget'


def client_of(address, password=PASSWORD, **options):
    return RwsClient(RwsAccess(address, USER, password, **options))


def test_the_emulator_runs_what_is_loaded_and_stops(model, start_deg):
    motors = MotorSide(model, start_deg, None, CellSettings(), 0.0)
    task = ProgramTask(motors.controller, GuidanceSettings(), np.random.default_rng(1))
    station = Station(motors.controller, task, threading.Lock())
    server = RwsServer(station, '127.0.0.1', 0, USER, PASSWORD)
    try:
        client = client_of(f'127.0.0.1:{server.port}')
        client.load(PROGRAM)
        assert not motors.controller.running
        client.run(PROGRAM)
        motors.cycle()
        assert motors.controller.running
        client.stop()
        motors.cycle()
        assert not motors.controller.running
        motors.controller.set_automatic(False)
        with pytest.raises(BridgeError, match='MANR'):
            client.check_automatic()
        wrong = client_of(f'127.0.0.1:{server.port}', 'another')
        with pytest.raises(BridgeError, match='rws_password_file') as caught:
            wrong.stop()
        assert 'another' not in str(caught.value)
    finally:
        server.close()


def test_what_is_asked_in_which_order(web):
    controller = web()
    client = client_of(controller.address)
    client.load(PROGRAM)
    client.run(PROGRAM)
    client.stop()
    ready = [
        'GET /rw/panel/opmode?json=1',
        'GET /rw/panel/ctrlstate?json=1',
        'GET /rw/rapid/execution?json=1',
        'GET /rw/rapid/tasks?json=1',
    ]
    assert controller.requests == [
        'GET /rw/system',
        *ready,
        f'GET {JOINT_TARGET}?json=1',
        'POST /rw/mastership/rapid?action=request',
        'PUT /fileservice/$HOME/AmaExcitation_1.mod',
        'GET /rw/rapid/modules?task=T_ROB1&json=1',
        'POST /rw/rapid/tasks/T_ROB1?action=loadmod',
        'POST /rw/rapid/execution?action=resetpp',
        'POST /rw/mastership/rapid?action=release',
        'POST /rw/mastership/rapid?action=request',
        *ready,
        'GET /rw/rapid/modules/AmaExcitation_1?resource=module-text&task=T_ROB1&json=1',
        'GET /rw/rapid/tasks/T_ROB1/pcp?json=1',
        f'GET {JOINT_TARGET}?json=1',
        'POST /rw/rapid/execution?action=start',
        'POST /rw/mastership/rapid?action=release',
        'GET /rw/rapid/execution?json=1',
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
    client = client_of(controller.address)
    with pytest.raises(BridgeError, match=value):
        client.load(PROGRAM)
    assert all(item.startswith('GET') for item in controller.requests)


def place(**axes):
    start = {f'rax_{n}': str(angle) for n, angle in enumerate(PROGRAM.start_deg, 1)}
    return {**start, **{f'eax_{letter}': '9E+09' for letter in 'abcdef'}, **axes}


def task(name='T_ROB1', kind='norm', active='On', moves='TRUE'):
    return {'name': name, 'type': kind, 'active': active, 'motiontask': moves}


TASKS, PCP = '/rw/rapid/tasks', '/rw/rapid/tasks/T_ROB1/pcp'
AWAY = {
    'axis 1 far away': (JOINT_TARGET, place(rax_1='80')),
    'axis 6 just away': (JOINT_TARGET, place(rax_6='0.06')),
    'one turn away': (JOINT_TARGET, place(rax_6='360')),
    'not a number': (JOINT_TARGET, place(rax_3='nan')),
    'not told': (JOINT_TARGET, {}),
    'two arms': (TASKS, [task(), task('T_ROB2')]),
    'a task of inputs and outputs': (TASKS, [task(), task('T_IO', moves='FALSE')]),
    'task deselected': (TASKS, task(active='Off')),
    'no tasks told': (TASKS, []),
}


@pytest.mark.parametrize('case', AWAY)
def test_nothing_is_loaded_nor_started_elsewhere_or_beside_others(web, case):
    controller = web(states=dict([AWAY[case]]))
    client = client_of(controller.address)
    for ask in (client.check, client.load, client.run):
        with pytest.raises(BridgeError) as caught:
            ask(PROGRAM)
        assert len(str(caught.value).splitlines()) == 1
    assert set(controller.posts()) == set()
    assert not any(item.startswith('PUT') for item in controller.requests)


TEXT = '/rw/rapid/modules/AmaExcitation_1'
NOT_IT = {
    'another text': (TEXT, {'module-text': MODULE.replace('0.1', '0.2')}),
    'no text': (TEXT, {}),
    'a file elsewhere': (TEXT, {'file-path': 'C:/temp/x.modx'}),
    'pointer in another module': (
        PCP, {'_title': 'progpointer', 'modulemame': 'MainModule', 'routinename': 'main'}
    ),
    'pointer in another routine': (
        PCP, {'_title': 'progpointer', 'modulemame': PROGRAM.name, 'routinename': 'CheckPlace'}
    ),
    'no pointer': (PCP, []),
    'jogged away since': (JOINT_TARGET, place(rax_2='46')),
}  # fmt: skip


@pytest.mark.parametrize('case', NOT_IT)
def test_nothing_is_started_that_was_not_released(web, case):
    controller = web()
    client = client_of(controller.address)
    client.load(PROGRAM)
    controller.states.update([NOT_IT[case]])
    with pytest.raises(BridgeError) as caught:
        client.run(PROGRAM)
    assert len(str(caught.value).splitlines()) == 1
    assert 'start' not in controller.posts()


def test_case_spaces_and_a_file_header_of_the_controller_are_no_other_text(web):
    controller = web()
    client = client_of(controller.address)
    client.load(PROGRAM)
    text = '%%%\n VERSION:1\n LANGUAGE:ENGLISH\n%%%\n\n' + MODULE.replace('PROC main', 'PROC Main')
    for form in (text, text.replace('\n', '\r\n'), quote(text)):
        controller.states[TEXT] = {'module-text': form}
        client.run(PROGRAM)
    assert controller.posts().count('start') == 3


def test_a_statement_that_a_comment_takes_in_makes_another_text():
    text = MODULE.replace('  PROC', '  ! keep "all" away\n  PROC').replace(
        '    Wait', '    CheckPlace; ! first\n    TPWrite "now!";\n    Wait'
    )
    program = replace(PROGRAM, text=text)
    assert program.is_text(text.replace('\n', '\r\n').replace('  ', '\t'))
    assert not program.is_text(text.replace('! first\n', '! first'))
    assert not program.is_text(text.replace('away\n', 'away'))
    assert not program.is_text(text.replace('CheckPlace;', '!CheckPlace;'))
    assert not program.is_text(text.replace('    CheckPlace; ! first', '    ! CheckPlace; first'))


def test_a_controller_in_run_mode_continuous_is_found_out(web):
    controller = web(
        states={'/rw/rapid/execution': {'ctrlexecstate': 'stopped', 'cycle': 'forever'}}
    )
    client = client_of(controller.address)
    client.load(PROGRAM)
    with pytest.raises(BridgeError, match='begin anew'):
        client.run(PROGRAM)


class ReleasedCell:
    """The emulator's web services with an exported program, standing where it is told."""

    def __init__(self, model, plan, away_deg=0.0):
        start = np.degrees(model.to_controller(plan.start_position))
        self.motors = MotorSide(model, start + away_deg, None, CellSettings(), 0.0)
        self.controller = self.motors.controller
        self.task = ProgramTask(self.controller, GuidanceSettings(), np.random.default_rng(1))
        station = Station(self.controller, self.task, threading.Lock())
        self.server = RwsServer(station, '127.0.0.1', 0, USER, PASSWORD)
        self.client = client_of(f'127.0.0.1:{self.server.port}')
        text = rapid_module(plan, model)
        self.program = ReleasedProgram(module_name(plan), text, tuple(start), 0.05)


@pytest.fixture(scope='module')
def released(model):
    request = PlanRequest(
        seed=13, signal='random_pulses', duration_s=4.0, interval_high_s=0.1,
        start_position=tuple(model.pose('P1').tolist()),
    )  # fmt: skip
    return plan_excitation(model, None, request)


@pytest.mark.parametrize('away_deg', [80.0, 0.06, -0.06, 0.0])
def test_start_by_web_services_sweeps_no_arm_to_the_start_pose(model, released, away_deg):
    cell = ReleasedCell(model, released, away_deg * np.eye(6)[0])
    before = cell.controller.axes.planned_deg.copy()
    try:
        if away_deg:
            with pytest.raises(BridgeError, match='axis 1 is not at the start pose'):
                cell.client.load(cell.program)
            for _ in range(200):
                cell.motors.cycle()
            assert np.array_equal(cell.controller.axes.planned_deg, before)
        else:
            cell.task.cycle = 'forever'
            cell.client.load(cell.program)
            cell.client.run(cell.program)
            assert cell.task.cycle == 'once'
            cell.motors.cycle()
            assert cell.controller.running
    finally:
        cell.server.close()


def test_modules_of_other_plans_go_and_other_programs_stay_in_the_way(model, released):
    cell = ReleasedCell(model, released)
    try:
        older = replace(
            cell.program, name='AmaExcitation_00000000',
            text=cell.program.text.replace(cell.program.name, 'AmaExcitation_00000000'),
        )  # fmt: skip
        cell.client.load(older)
        # So long that the controller answers with a file in place of the text.
        cell.program = replace(cell.program, text=cell.program.text + '! and more\n' * 3000)
        cell.client.load(cell.program)
        assert list(cell.task.texts) == [cell.program.name]
        cell.client.run(cell.program)
        cell.client.stop()
        cell.client.load(
            replace(older, name='MainModule', text=older.text.replace(older.name, 'MainModule'))
        )
        with pytest.raises(BridgeError, match='program pointer'):
            cell.client.run(cell.program)
        assert not cell.controller.running
    finally:
        cell.server.close()


def test_only_modules_with_the_hash_of_a_plan_are_unloaded(web):
    others = ('AmaExcitation_spare', 'AmaExcitation_0123abcdX', 'Other_01234567', 'AmaExcitation_')
    for names, n_unloaded in ((others, 0), ((*others, 'AMAEXCITATION_0123ABCD'), 1)):
        controller = web(states={'/rw/rapid/modules': [{'name': name} for name in names]})
        client_of(controller.address).load(PROGRAM)
        assert controller.posts().count('unloadmod') == n_unloaded


@pytest.mark.parametrize(
    ('status', 'headers'),
    [
        (401, {'WWW-Authenticate': 'Basic realm="validuser@robapi.abb"'}),
        (301, {'Location': 'https://127.0.0.1/rw/panel/opmode'}),
    ],
    ids=['basic', 'https'],
)
def test_nobody_gets_the_password_without_encryption(web, status, headers):
    controller = web(answers={'/rw/system': (status, headers)})
    for address in (controller.address, f'http://{controller.address}'):
        with pytest.raises(BridgeError) as caught:
            client_of(address).check_automatic()
        assert len(str(caught.value).splitlines()) == 1
    assert set(controller.authorisations) == {''}


@pytest.mark.parametrize(
    'address', ['https://192.168.125.1/rw', 'ftp://a', 'a/b', '', 'a:b', 'user:word@host']
)
def test_an_address_that_cannot_be_meant_is_refused_at_once(address):
    with pytest.raises(BridgeError, match='rws_address'):
        client_of(address)


def test_an_unreachable_controller_is_one_line():
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    with pytest.raises(BridgeError, match='cannot be reached') as caught:
        client_of(f'127.0.0.1:{port}').stop()
    assert PASSWORD not in str(caught.value)


@contextlib.contextmanager
def raw_controller(begin, then=b''):
    """Answer every request with these bytes, and with others every 0.05 s after them.

    Beside the address it says how many of the others went out for each request.
    """
    closing, n_pieces = threading.Event(), []

    def answer(peer):
        mine = len(n_pieces)
        n_pieces.append(0)
        with peer, contextlib.suppress(OSError):
            peer.recv(65536)
            peer.sendall(begin)
            while not closing.wait(0.05):
                peer.sendall(then)
                n_pieces[mine] += bool(then)

    def serve(server):
        with contextlib.suppress(OSError):
            while True:
                threading.Thread(target=answer, args=server.accept()[:1], daemon=True).start()

    with socket.create_server(('127.0.0.1', 0)) as server:
        threading.Thread(target=serve, args=(server,), daemon=True).start()
        yield f'127.0.0.1:{server.getsockname()[1]}', n_pieces
        closing.set()


def http(status, length, content=b'', header=''):
    head = f'HTTP/1.1 {status} any\r\nContent-Length: {length}\r\n{header}\r\n'
    return head.encode() + content


ZIPPED = gzip.compress(b'{"_embedded": {"_state": [{"opmode": "AUTO"}]}}')
CHUNKED = b'HTTP/1.1 200 any\r\nTransfer-Encoding: chunked\r\n\r\n'
DIGEST = 'WWW-Authenticate: Digest realm="a", nonce="b"'
ENDLESS = {
    'a blank now and then': (http(200, 999_999_999), b' '),
    'megabytes': (http(200, 999_999_999), b' ' * 1_000_000),
    'nothing': (b'', b''),
    'a refusal without its text': (http(503, 100), b''),
    'a refusal cut in its text': (http(503, 100, b'no'), b''),
    'brackets': (http(200, 1_000_000, b'[' * 1_000_000), b''),
    'a list': (http(200, 2, b'[]'), b''),
    'a picture': (http(200, 4, b'\x89PNG', 'Content-Type: image/png\r\n'), b''),
    'a challenge without realm': (http(401, 0, header='WWW-Authenticate: Digest realm=\r\n'), b''),
    'elsewhere': (http(302, 0, header='Location: http://127.0.0.1:1/\r\n'), b''),
    'no http': (b'\x00\xff\r\n\r\n', b''),
    'zipped': (http(200, len(ZIPPED), ZIPPED, 'Content-Encoding: gzip\r\n'), b''),
    'xhtml': (http(200, 13, b'<html></html>', 'Content-Type: application/xhtml+xml\r\n'), b''),
    'chunks without end': (CHUNKED, b'1\r\n \r\n'),
    'a broken chunk': (CHUNKED, b'zz\r\n'),
    'digest for ever': (
        http(401, 0, header='WWW-Authenticate: Digest realm="a", nonce="b"\r\n'),
        b'',
    ),
    'an unknown digest': (http(401, 0, header=DIGEST + ', algorithm=X\r\n'), b''),
    'too many headers': (http(200, 2, b'[]', 'X: y\r\n' * 1000), b''),
    'a negative length': (http(200, -1, b'[]'), b''),
    'another coding': (
        http(200, 2, b'\xff\xfe', 'Content-Type: text/html; charset=none\r\n'),
        b'',
    ),
}


@pytest.mark.parametrize('kind', ENDLESS)
def test_whatever_web_services_answer_is_refused_in_time_and_in_one_line(kind):
    """0.3 s are given for an answer: each piece comes in time, all of them never."""
    with raw_controller(*ENDLESS[kind]) as (address, n_pieces):
        client = client_of(address, timeout_s=0.3)
        for ask in (client.check_automatic, lambda: client.check(PROGRAM)):
            with pytest.raises(BridgeError) as caught:
                ask()
            assert '\n' not in str(caught.value) and PASSWORD not in str(caught.value)
        with contextlib.suppress(BridgeError):  # an action is done whatever the answer shows
            client.stop()
        # A piece every 0.05 s: six come in time, and few more until the socket is seen closed.
        assert len(n_pieces) >= 2 and max(n_pieces) < 100


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
