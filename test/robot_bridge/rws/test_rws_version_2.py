"""Robot Web Services 2.0: the version that answers, and the certificate before the password."""

from dataclasses import replace
import ssl
import subprocess

import pytest

from abb_emulator.rws import self_signed
from abb_emulator.rws.rws_server import RwsServer
from modal_core.errors import BridgeError
from robot_bridge.backends.backends import BackendSettings, make_backend
from robot_bridge.rws.released_program import ReleasedProgram
from robot_bridge.rws.rws_client import RwsClient
from robot_bridge.rws.web_services import RwsAccess, WebServices
from test.support.rws_cell import PASSWORD, RwsCell, USER

MODULE = """MODULE AmaExcitation_00000001
  PROC main()
    WaitTime 0.5;
  ENDPROC
ENDMODULE
"""


@pytest.fixture
def cell(model, start_deg):
    made = RwsCell(model, start_deg, (2,))
    yield made
    made.close()


@pytest.fixture
def program(start_deg):
    return ReleasedProgram('AmaExcitation_00000001', MODULE, tuple(start_deg.tolist()), 0.05)


def access(cell, **options):
    options = {'certificate': cell.servers[2].fingerprint, **options}
    return RwsAccess(options.pop('address', cell.address(2)), USER, PASSWORD, **options)


def run_program(cell, client, program):
    client.check_automatic()
    client.load(program)
    assert not cell.controller.running
    client.run(program)
    cell.motors.cycle()
    assert cell.controller.running
    assert cell.task.cycle == 'once'
    client.stop()
    cell.motors.cycle()
    assert not cell.controller.running


def test_a_program_is_loaded_started_and_stopped(cell, program):
    run_program(cell, RwsClient(access(cell)), program)
    older = replace(
        program, name='AmaExcitation_00000002', text=MODULE.replace('on_00000001', 'on_00000002')
    )
    client = RwsClient(access(cell, certificate=cell.servers[2].fingerprint.upper()))
    client.load(older)
    assert list(cell.task.texts) == ['AmaExcitation_00000002']
    longer = replace(program, text=MODULE + '! and more\n' * 3000)
    client.load(longer)
    with pytest.raises(BridgeError, match='not the one that was released'):
        client.run(program)
    client.run(longer)


@pytest.mark.parametrize('version', [1, 2])
def test_the_version_that_answers_is_spoken(model, start_deg, program, version):
    cell = RwsCell(model, start_deg, (version,))
    try:
        certificate = cell.servers[version].fingerprint
        where = RwsAccess(cell.address(version), USER, PASSWORD, certificate=certificate)
        run_program(cell, RwsClient(where), program)
        wrong = RwsClient(replace(where, password='another'))
        with pytest.raises(BridgeError, match='rws_password_file') as caught:
            wrong.check_automatic()
        assert 'another' not in str(caught.value)
        assert not cell.controller.running
    finally:
        cell.close()


def test_a_controller_of_robotware_7_sends_from_http_to_https(web, cell, program):
    """Port 80 of such a controller is asked first when the address says nothing."""
    port = web(answers={'/rw/system': (301, {'Location': 'https://elsewhere/'})})
    with pytest.raises(BridgeError, match='cannot be reached'):
        RwsClient(RwsAccess(port.address, USER, PASSWORD, 0.5)).check_automatic()
    assert port.requests == ['GET /rw/system']
    assert port.authorisations == ['']


def test_an_unknown_certificate_is_shown_and_gets_no_password(cell):
    client = RwsClient(access(cell, certificate=''))
    with pytest.raises(BridgeError) as caught:
        client.check_automatic()
    text = str(caught.value)
    assert cell.servers[2].fingerprint in text and 'rws_certificate' in text
    assert len(text.splitlines()) == 1
    assert cell.servers[2].n_credentials == 0


def test_another_certificate_than_the_pinned_one_is_refused_before_anything_is_sent(cell):
    pinned = f'{int(cell.servers[2].fingerprint, 16) ^ 1:064x}'
    with pytest.raises(BridgeError, match='another certificate') as caught:
        RwsClient(access(cell, certificate=pinned)).check_automatic()
    assert pinned in str(caught.value)
    assert cell.servers[2].n_credentials == 0


def test_a_certificate_that_changes_in_between_is_refused(model, start_deg, cell, program):
    client = RwsClient(access(cell))
    client.load(program)
    port = cell.servers[2].port
    cell.servers[2].close()
    impostor = RwsCell(model, start_deg)
    try:
        server = RwsServer(impostor.station, '127.0.0.1', port, USER, PASSWORD, 2)
        with pytest.raises(BridgeError, match='another certificate'):
            client.run(program)
        server.close()
        assert not impostor.controller.running
    finally:
        impostor.close()


def test_a_file_vouches_for_a_certificate(cell, tmp_path):
    file = tmp_path / 'controller.pem'
    host, port = cell.address(2).split(':')
    file.write_text(ssl.get_server_certificate((host, int(port))))
    RwsClient(access(cell, certificate=str(file))).check_automatic()
    # Of another address it says nothing.
    with pytest.raises(BridgeError, match='vouches'):
        RwsClient(
            access(cell, certificate=str(file), address=f'localhost:{port}')
        ).check_automatic()


def test_a_certificate_that_is_over_is_refused_by_who_vouches_and_taken_by_its_fingerprint(
    model, start_deg, program, tmp_path, monkeypatch
):
    kept = tmp_path / 'certificate.pem'

    def keep(folder, address, make=self_signed.make_certificate):
        certificate, key = make(folder, address)
        ended = ['-in', str(certificate), '-signkey', str(key), '-days', '-1', '-out', str(kept)]
        subprocess.run(['openssl', 'x509', *ended], check=True, capture_output=True)
        certificate.write_bytes(kept.read_bytes())
        return certificate, key

    monkeypatch.setattr(self_signed, 'make_certificate', keep)
    expired = RwsCell(model, start_deg, (2,))
    try:
        client = RwsClient(access(expired, certificate=str(kept)))
        with pytest.raises(BridgeError, match='expired') as caught:
            client.check_automatic()
        assert PASSWORD not in str(caught.value) and '\n' not in str(caught.value)
        RwsClient(access(expired)).check_automatic()
    finally:
        expired.close()


@pytest.mark.parametrize('text', ['abc', 'zz' * 32, '/nowhere/at/all.pem', 'a' * 63])
def test_what_is_no_certificate_is_refused_at_once(cell, text):
    with pytest.raises(BridgeError, match='rws_certificate'):
        RwsClient(access(cell, certificate=text))


def test_http_and_a_certificate_contradict_each_other(cell):
    with pytest.raises(BridgeError, match='HTTP has no certificate'):
        RwsClient(access(cell, address=f'http://{cell.address(2)}'))


def test_a_mastership_that_another_client_holds_is_one_line(cell, program):
    other = WebServices(access(cell))
    other.post('request')
    with pytest.raises(BridgeError, match='held by someone else') as caught:
        RwsClient(access(cell)).load(program)
    assert len(str(caught.value).splitlines()) == 1
    other.post('release')
    RwsClient(access(cell)).load(program)


def test_the_backend_hands_its_settings_on(cell, model):
    settings = BackendSettings(
        rws_address=cell.address(2), rws_certificate='abc', rws_password=PASSWORD, method='rapid'
    )
    with pytest.raises(BridgeError, match='rws_certificate'):
        make_backend(settings, model)
    make_backend(replace(settings, rws_certificate=cell.servers[2].fingerprint), model)
