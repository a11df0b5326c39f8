"""Clients of Robot Web Services that others wrote, against the emulated controller.

They run where they are installed (``pip install .[test]``); what they ask for byte by byte is also
asked in ``test_rws_wire.py``, which runs everywhere.
"""

import time
import warnings

import pytest

from test.support.rws_cell import MODULE, PASSWORD, RwsCell, USER
from test.support.web_client import WebClient

pytestmark = pytest.mark.filterwarnings('ignore')

LOAD = '/rw/rapid/tasks/T_ROB1?action=loadmod'


@pytest.fixture
def cell(model, start_deg):
    made = RwsCell(model, start_deg, (1, 2)).run()
    yield made
    made.close()


def until(condition, most_s=10.0):
    end = time.monotonic() + most_s
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    assert condition()


def test_abb_robot_client_gets_every_answer_as_of_a_controller(cell):
    rws = pytest.importorskip('abb_robot_client.rws')
    client = rws.RWS(f'http://{cell.address()}', USER, PASSWORD)
    assert client.get_ramdisk_path() == '$TEMP'
    client.upload_file('$HOME/small.mod', MODULE.encode())
    assert client.read_file('$HOME/small.mod') == MODULE.encode()
    assert client.list_files('$HOME') == ['small.mod']
    load = {'modulepath': '$HOME/small.mod'}
    assert WebClient(cell.servers[1].port).ask('POST', LOAD, load)[0] == 200
    client.resetpp()
    for cycle in ('once', 'forever'):
        client.start(cycle)
        assert client.get_execution_state() == ('running', cycle)
        with pytest.raises(rws.ABBException) as caught:
            client.start(cycle)
        assert caught.value.code == -1073442809
        client.stop()
        assert client.get_execution_state().ctrlexecstate == 'stopped'
        client.resetpp()
    assert client.get_tasks()['T_ROB1'].active
    client.deactivate_task('T_ROB1')
    assert not client.get_tasks()['T_ROB1'].active
    client.activate_task('T_ROB1')
    assert client.get_operation_mode() == 'AUTO'
    client.set_controller_state('motoroff')
    assert client.get_controller_state() == 'motoroff'
    with pytest.raises(rws.ABBException):
        client.start('once')
    client.set_controller_state('motoron')
    client.set_speedratio(50)
    assert client.get_speedratio() == 50.0
    assert client.get_jointtarget().robax[1] == pytest.approx(45.0, abs=1e-3)
    assert abs(client.get_robtarget().trans[2] - 1740.0) < 5.0
    assert client.read_event_log()[0].title == 'motors on'
    client.delete_file('$HOME/small.mod')
    assert client.list_files('$HOME') == []
    assert client.try_create_ipc_queue('q') and not client.try_create_ipc_queue('q')
    client.close()


def test_abb_robot_client_reads_and_sets_data_and_signals_and_is_told_of_changes(cell):
    rws = pytest.importorskip('abb_robot_client.rws')
    cell.task.load(MODULE)
    client = rws.RWS(f'http://{cell.address()}', USER, PASSWORD)
    kinds, events = rws.SubscriptionResourceType, []
    wanted = (
        kinds.ControllerState, kinds.OperationalMode, kinds.ExecutionState, kinds.Elog,
        (kinds.Signal, 'doAmaRun'), (kinds.PersVar, 'nCount'),
    )  # fmt: skip
    subscription = client.subscribe(
        [
            rws.SubscriptionResourceRequest(kind, rws.SubscriptionResourcePriority.Medium, *name)
            for kind, *name in (one if isinstance(one, tuple) else (one,) for one in wanted)
        ],
        events.append,
    )
    until(lambda: len(events) >= 5)
    client.set_digital_io('doAmaRun', 1)
    assert client.get_digital_io('doAmaRun') == 1
    client.set_rapid_variable('nCount', '7')
    assert client.get_rapid_variable('nCount') == '7'
    assert [item['name'] for item in client.get_rapid_variables()] == ['ncount']
    client.set_controller_state('motoroff')
    until(lambda: rws.ControllerState('motoroff') in events)
    until(lambda: rws.Signal('doAmaRun', '1') in events)
    until(lambda: any(isinstance(item, rws.EventLogEntryEvent) for item in events))
    assert any(isinstance(item, rws.VariableValue) and item.value == '7' for item in events)
    subscription.close()


def test_rwsuis_runs_a_program(cell, capsys):
    module = pytest.importorskip('rwsuis.RWS')
    cell.task.load(MODULE)
    client = module.RWS(f'http://{cell.address()}', USER, PASSWORD)
    client.request_mastership()
    client.motors_on()
    client.start_RAPID()
    assert client.is_running()
    client.stop_RAPID()
    client.set_speed_ratio(40)
    client.release_mastership()
    assert 'Could not' not in capsys.readouterr().out
    assert client.get_rapid_variable('nCount') == '3'
    assert client.set_rapid_variable('nCount', 5).status_code == 204
    assert cell.controller.speed_ratio == 0.4


def test_rwswrap_runs_a_program_by_version_2(cell):
    module = pytest.importorskip('rwswrap.RWS')
    warnings.simplefilter('ignore')
    client = module.RWS(f'https://{cell.address(2)}', USER, PASSWORD, module='arrs_mod')
    put = client.session.put(
        f'{client.base_url}/fileservice/$HOME/arrs_mod.modx', verify=False,
        data=MODULE.replace('Small', 'arrs_mod'), headers={'Content-Type': 'text/plain;v=2.0'},
    )  # fmt: skip
    assert put.status_code == 201
    assert client.load_module().status_code == 200
    assert client.get_modules() == ['arrs_mod']
    assert client.set_rapid_variable('nCount', 9).status_code == 204
    assert client.get_rapid_variable('nCount') == '9'
    assert client.start_RAPID().status_code == 204
    assert client.is_running()
    assert client.stop_RAPID().status_code == 204
    assert client.get_exec_state() == 'stopped'
