"""The bridge as an operator's tools meet it: life cycle, parameters, reference, secrets."""

import copy
import os
from pathlib import Path
import time

from lifecycle_msgs.msg import State, Transition, TransitionEvent
from lifecycle_msgs.srv import (
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
import numpy as np
import pytest
from rcl_interfaces.msg import Log, Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from sensor_msgs.msg import JointState

from test.support.web_controller import WebController

pytestmark = pytest.mark.node
IDLE, RUNNING, HOLDING, ABORTED = 1, 3, 5, 6
SECRET = 'not-to-be-seen'
NODE = '/robot_bridge'
CALM = {'link_timeout_s': 10.0, 'heartbeat_timeout_s': 10.0}  # a busy machine is no lost link


@pytest.fixture(scope='module')
def heard(operator):
    """Return all that is logged, referred to and said of the life cycle."""
    found = {'log': [], 'reference': [], 'event': []}
    create = operator.node.create_subscription
    create(Log, '/rosout', found['log'].append, 100)
    create(JointState, f'{NODE}/reference', found['reference'].append, 100)
    create(TransitionEvent, f'{NODE}/transition_event', found['event'].append, 100)
    return found


def change(operator, transition):
    request = Transition(id=transition)
    return operator.call(f'{NODE}/change_state', ChangeState, transition=request).success


def label(operator):
    return operator.call(f'{NODE}/get_state', GetState).current_state.label


def set_parameter(operator, name, **value):
    kinds = {
        'double_value': ParameterType.PARAMETER_DOUBLE,
        'integer_value': ParameterType.PARAMETER_INTEGER,
        'string_value': ParameterType.PARAMETER_STRING,
        'bool_value': ParameterType.PARAMETER_BOOL,
    }
    kind = kinds[next(iter(value))]
    parameter = Parameter(name=name, value=ParameterValue(type=kind, **value))
    answer = operator.call(f'{NODE}/set_parameters', SetParameters, parameters=[parameter])
    return answer.results[0]


def figures(operator):
    """Return the figures of the bridge's newest diagnostic."""
    found = [
        status
        for array in list(operator.diagnostics)
        for status in array.status
        if 'bridge' in status.name
    ]
    return {item.key: item.value for item in found[-1].values} if found else {}


def test_life_cycle_tools_parameters_and_a_dry_run(
    processes, drivers, operator, peers, heard, message, start_deg
):
    port = drivers.free_port()
    process = processes('robot_bridge', port=port, autostart=False, dry_run=True, **CALM)
    operator.until(lambda: operator.last is not None, 'state', 90.0)
    shows_its_life_cycle(operator)
    refuses_wrong_values(operator)
    configures_only_with_an_address(operator)
    assert not set_parameter(operator, 'dry_run', bool_value=False).successful
    assert change(operator, Transition.TRANSITION_ACTIVATE)
    assert label(operator) == 'active'
    operator.until(
        lambda: [item.goal_state.label for item in heard['event']][-1:] == ['active'], 'event'
    )
    describes_its_parameters(operator)
    peer = peers.StrictPeer(start_deg, ('127.0.0.1', port), patience_s=0.0)
    peer.expect_reply = False
    try:
        peer.start()
        operator.hold().until_connected()
        counts_missed_cycles(operator, peer)
        refuses_a_changed_plan(operator, message)
        shows_what_it_would_send(operator, peer, heard, message)
        # Shut down in motion: at rest first, then finalised.
        assert change(operator, Transition.TRANSITION_ACTIVE_SHUTDOWN)
        assert label(operator) == State(label='finalized').label
        assert peer.replies == [] and peer.faults == []
    finally:
        peer.close()
        assert 'Traceback' not in process.stop()


def shows_its_life_cycle(operator):
    """What `ros2 lifecycle` asks."""
    states = operator.call(f'{NODE}/get_available_states', GetAvailableStates).available_states
    assert {'unconfigured', 'inactive', 'active', 'finalized'} <= {item.label for item in states}
    may = operator.call(f'{NODE}/get_available_transitions', GetAvailableTransitions)
    assert 'configure' in {item.transition.label for item in may.available_transitions}
    assert label(operator) == 'unconfigured'
    assert not change(operator, Transition.TRANSITION_ACTIVATE)


def refuses_wrong_values(operator):
    """A wrong value is told with its range, and the old one stays."""
    for name, value, words in (
        ('ramp_in_s', {'double_value': 0.0}, 'range'),
        ('stop_ramp_s', {'double_value': float('nan')}, ''),
        ('port', {'integer_value': 70_000}, 'range'),
        ('heartbeat_timeout_s', {'double_value': -1.0}, 'range'),
        ('dry_run', {'double_value': 1.0}, 'type'),
    ):
        refused = set_parameter(operator, name, **value)
        assert not refused.successful and words in refused.reason, (name, refused.reason)


def configures_only_with_an_address(operator):
    assert set_parameter(operator, 'controller_address', string_value='robot').successful
    assert not change(operator, Transition.TRANSITION_CONFIGURE)
    operator.until(lambda: 'not an IP address' in operator.last.reason, 'reason')
    assert label(operator) == 'unconfigured'
    assert set_parameter(operator, 'controller_address', string_value='127.0.0.1').successful
    assert change(operator, Transition.TRANSITION_CONFIGURE)
    assert label(operator) == 'inactive'


def describes_its_parameters(operator):
    """Every parameter is described, every number has its range."""
    names = operator.call(f'{NODE}/list_parameters', ListParameters).result.names
    ours = [name for name in names if not name.startswith(('qos_', 'start_type', 'use_sim'))]
    described = operator.call(f'{NODE}/describe_parameters', DescribeParameters, names=ours)
    for item in described.descriptors:
        assert item.description, item.name
        if item.type in (ParameterType.PARAMETER_INTEGER, ParameterType.PARAMETER_DOUBLE):
            assert item.integer_range or item.floating_point_range, item.name


def counts_missed_cycles(operator, peer):
    """Seven packets that never come are counted, in the state and in the diagnostics."""
    peer.pause()
    peer.seqno += 7
    peer.start()
    operator.until(lambda: operator.last.n_missed_cycles >= 7, 'missed cycles')
    operator.diagnostics.clear()
    operator.until(lambda: int(figures(operator).get('missed_cycles', 0)) >= 7, 'diagnostics')
    shown = figures(operator)
    assert {'reply_latency_p50_ms', 'reply_latency_p99_ms', 'received', 'sent'} <= set(shown)


def refuses_a_changed_plan(operator, message):
    """A plan that is not what its hash says is refused."""
    changed = copy.deepcopy(message)
    changed.velocity[100] += 1e-6
    operator.plans.publish(changed)
    operator.until(
        lambda: any(code.startswith('PLAN_REFUSED') for code in operator.codes('bridge')),
        'refusal',
    )
    assert operator.last.plan_hash == ''


def shows_what_it_would_send(operator, peer, heard, message):
    """A dry run sends nothing, and shows the motion it would ask for."""
    operator.offer(message)
    assert not heard['reference']
    assert operator.arm(message.plan_hash).accepted
    assert operator.start().success
    operator.until(lambda: operator.last.progress > 0.3, 'progress')
    operator.until(lambda: len(heard['reference']) > 100, 'reference')
    moved = np.ptp([item.position for item in heard['reference']], axis=0)
    assert moved.max() > 1e-5
    assert peer.replies == [] and operator.last.n_sent == 0


def test_abort_does_not_wait_for_a_start_and_the_password_is_nowhere(
    processes, drivers, operator, heard, pulses, tmp_path
):
    web = WebController(hold='loadmod')
    secret = tmp_path / 'password'
    secret.write_text(f'{SECRET}\n')
    operator.states.clear()
    log = tmp_path / 'egm.mcap'
    process = processes(
        'robot_bridge',
        port=drivers.free_port(),
        method='rapid',
        dry_run=False,
        **CALM,
        rapid_file=str(tmp_path / 'plan.mod'),
        rws_address=web.address,
        rws_password_file=str(secret),
        packet_log=str(log),
    )
    try:
        operator.hold().until(lambda: operator.last is not None, 'state', 90.0)
        operator.offer(pulses)
        assert operator.arm(pulses.plan_hash).accepted
        starting = operator.client(f'{NODE}/start', drivers.StartPlan).call_async(
            drivers.StartPlan.Request(token=operator.token)
        )
        operator.until(web.waiting.is_set, 'load')
        assert operator.abort().success
        assert not starting.done()
        web.release.set()
        operator.until(starting.done, 'refusal')
        assert not starting.result().success
        assert 'aborted by the operator' in starting.result().message
        operator.until_state(ABORTED)
        assert 'start' not in web.posts()
        # Nowhere: parameters, states, diagnostics, log, packet log, module, error channel.
        names = operator.call(f'{NODE}/list_parameters', ListParameters).result.names
        values = operator.call(f'{NODE}/get_parameters', GetParameters, names=names).values
        operator.until(lambda: operator.diagnostics, 'diagnostics')
        said = process.stop()
        shown = (values, operator.states, operator.diagnostics, heard['log'], said)
        assert all(SECRET not in str(item) for item in shown)
        for file in tmp_path.iterdir():
            assert file == secret or SECRET.encode() not in file.read_bytes(), file
        assert b'ABORTED: aborted by the operator' in log.read_bytes()
        arguments = Path(f'/proc/{os.getpid()}/cmdline').read_bytes()
        assert SECRET.encode() not in arguments
    finally:
        web.close()
        process.stop()


def test_a_stream_of_refused_plans_is_logged_once_in_five_seconds(
    processes, drivers, operator, message
):
    changed = copy.deepcopy(message)
    changed.velocity[100] += 1e-6
    operator.states.clear()
    process = processes('robot_bridge', port=drivers.free_port())
    operator.until(lambda: operator.states, 'state')
    began_s = time.monotonic()
    for _ in range(40):
        operator.plans.publish(changed)
        time.sleep(0.05)
    operator.until(
        lambda: any(code.startswith('PLAN_REFUSED') for code in operator.codes('bridge')),
        'refusal',
    )
    took_s = time.monotonic() - began_s
    assert 1 <= process.stop().count('plan refused') <= 2 + took_s / 5.0
