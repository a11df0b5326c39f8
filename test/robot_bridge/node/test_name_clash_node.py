"""One operator, one arm: where names clash nothing moves, and beats count by their token."""

import signal
import time

import pytest

pytestmark = pytest.mark.node
IDLE, ARMED, RUNNING, ABORTED = 1, 2, 3, 6
CALM = {'link_timeout_s': 2.0, 'heartbeat_timeout_s': 2.0, 'dry_run': False}


class Cell:
    """A bridge with a controller of its own."""

    def __init__(self, rig, number, **parameters):
        self.port = rig.drivers.free_port()
        self.bridge = rig.processes('robot_bridge', port=self.port, **CALM, **parameters)
        self.peer = rig.peers.StrictPeer(rig.start_deg, ('127.0.0.1', self.port), patience_s=0.2)
        self.peer.start()
        self.number = number

    @property
    def controller(self):
        return f'127.0.0.1:{self.port}'

    def close(self):
        self.peer.close()
        self.bridge.stop()


class Rig:
    def __init__(self, drivers, processes, peers, start_deg, operator):
        self.drivers, self.processes, self.peers = drivers, processes, peers
        self.start_deg, self.operator, self.cells = start_deg, operator, []

    def cell(self, **parameters):
        self.cells.append(Cell(self, len(self.cells), **parameters))
        return self.cells[-1]

    def connected(self, cell):
        operator = self.operator
        operator.until(
            lambda: operator.last and operator.last.connected
            and operator.last.controller == cell.controller
            and operator.last.controller_state == 'running',
            'connection',
        )  # fmt: skip
        return operator

    def close(self):
        for cell in self.cells:
            cell.close()


@pytest.fixture
def rig(drivers, processes, peers, start_deg, operator):
    operator.states.clear()
    operator.diagnostics.clear()
    operator.hold()
    made = Rig(drivers, processes, peers, start_deg, operator)
    yield made
    made.close()


def fastest(peer, seen=0):
    """Return the largest speed asked of a controller [deg/s]."""
    return max((max(map(abs, item[2])) for item in peer.history[seen:] if item[2]), default=0.0)


def test_a_second_bridge_of_the_same_name_moves_no_arm_and_stops_the_first(rig, message):
    first = rig.cell()
    operator = rig.connected(first)
    operator.offer(message)
    answer = operator.arm(message.plan_hash, controller=first.controller)
    assert answer.accepted, answer.message
    assert operator.start().success
    operator.until(lambda: operator.last.progress > 0.05, 'progress')
    second = rig.cell()
    operator.until(
        lambda: any('NAME_CLASH' in text for text in operator.codes('robot_bridge')), 'clash'
    )
    operator.until(
        lambda: {state.controller for state in operator.states[-20:] if 'another node' in
                 state.reason} == {first.controller, second.controller}, 'both say it',
    )  # fmt: skip
    operator.until(
        lambda: any(
            state.state == ABORTED and state.controller == first.controller
            for state in operator.states[-10:]
        ),
        'abort of the first',
    )
    # Whatever the operator asks now, and of whichever bridge it comes to: nothing moves.
    seen = [len(cell.peer.history) for cell in rig.cells]
    time.sleep(0.3)
    for cell in rig.cells:
        assert not operator.reset().success
        assert not operator.arm(message.plan_hash, controller=cell.controller).accepted
        assert not operator.start().success
    time.sleep(0.5)
    for cell, n_packets in zip(rig.cells, seen, strict=True):
        assert fastest(cell.peer, n_packets + 50) == 0.0
    assert fastest(second.peer) == 0.0
    # Alone again: latched until somebody resets it, and then it works as before.
    second.bridge.stop()
    operator.states.clear()
    operator.until(lambda: operator.reset().success, 'reset')
    assert rig.connected(first).arm(message.plan_hash, controller=first.controller).accepted


@pytest.mark.slow
def test_it_begins_only_when_the_other_is_gone(rig, message):
    first = rig.cell()
    operator = rig.connected(first)
    second = rig.cell()
    operator.until(
        lambda: any(state.controller == second.controller and 'not active' in state.reason
                    and 'another node' in state.reason for state in operator.states), 'refusal',
    )  # fmt: skip
    first.close()
    rig.cells.remove(first)
    rig.connected(second)
    operator.offer(message)
    operator.until(lambda: operator.arm(message.plan_hash).accepted, 'release')


def waiting_cell(rig, first):
    """Return a second cell that waits for the first one's names."""
    second = rig.cell()
    rig.operator.until(
        lambda: any(state.controller == second.controller and 'not active' in state.reason
                    and 'another node' in state.reason for state in rig.operator.states), 'wait',
    )  # fmt: skip
    return second


@pytest.mark.slow
def test_a_killed_bridge_holds_its_successor_up_for_seconds_only(rig, message):
    """Its participant stays in the ROS graph for up to 20 s, its signs of life end at once."""
    first = rig.cell()
    operator = rig.connected(first)
    second = waiting_cell(rig, first)
    first.bridge.kill()
    operator.states.clear()
    operator.until(
        lambda: operator.last and 'not active' not in operator.last.reason, 'activation', 12.0
    )
    # What is dead is still known of; it hides nobody who lives.
    assert operator.node.count_publishers('/robot_bridge/state') == 2
    rig.connected(second)
    operator.until(lambda: operator.reset().success or operator.last.state == IDLE, 'reset')
    third = rig.cell()
    operator.until(
        lambda: {state.controller for state in operator.states[-20:] if 'another node' in
                 state.reason} == {second.controller, third.controller}, 'both say it',
    )  # fmt: skip


@pytest.mark.slow
def test_a_bridge_that_stood_still_takes_itself_for_dead(rig, message):
    """Its successor has taken its place: what it is asked the moment it goes on moves nothing."""
    first = rig.cell()
    operator = rig.connected(first)
    operator.offer(message)
    operator.until(lambda: operator.last.plan_hash == message.plan_hash, 'plan')
    second = waiting_cell(rig, first)
    first.bridge.process.send_signal(signal.SIGSTOP)
    operator.states.clear()
    operator.until(
        lambda: operator.last and 'not active' not in operator.last.reason, 'activation', 12.0
    )
    operator.states.clear()
    asked = [operator.arm_later(message.plan_hash, first.controller) for _ in range(3)]
    first.bridge.process.send_signal(signal.SIGCONT)
    operator.until(
        lambda: {state.controller for state in operator.states[-20:] if state.state == ABORTED
                 and 'clash' in state.reason} == {first.controller, second.controller}, 'clash',
    )  # fmt: skip
    assert not any(future.done() and future.result().accepted for future in asked)
    assert not any(state.state in (ARMED, RUNNING) for state in operator.states)
    for cell in rig.cells:
        assert fastest(cell.peer) == 0.0


def test_a_release_is_of_one_controller_one_operator_and_one_plan(rig, message):
    cell = rig.cell()
    operator = rig.connected(cell)
    operator.offer(message)
    for controller in ('', '127.0.0.1:1', '10.0.0.1:6510', 'IRB 6660'):
        refused = operator.arm(message.plan_hash, controller=controller)
        assert not refused.accepted and not refused.token
        assert cell.controller in refused.message
    old = operator.arm(message.plan_hash).token
    first = operator.arm(message.plan_hash).token
    assert len({old, first, ''}) == 3
    for token in ('', old, first[:-1], 'ü' * 32):
        operator.token = token
        refused = operator.start()
        assert not refused.success and 'token' in refused.message
    # The token of another release keeps nothing alive, and is told of.
    operator.token = old
    time.sleep(2.5)
    operator.token = first
    operator.holding = False
    refused = operator.start()
    assert not refused.success and 'heartbeat' in refused.message
    operator.until(
        lambda: any('FOREIGN_HEARTBEAT' in text for text in operator.codes('robot_bridge')), 'code'
    )
    operator.hold()
    assert operator.start().success
    operator.until(lambda: operator.last.progress > 0.05, 'progress')
    operator.token = old
    operator.until_state(ABORTED)
    assert 'heartbeat' in operator.last.reason


@pytest.mark.slow
def test_robots_in_their_own_namespaces_stand_side_by_side(rig, drivers, domain):
    ports = [drivers.free_port() for _ in range(2)]
    seen = {}
    for name, port in zip(('cell_a', 'cell_b'), ports, strict=True):
        seen[name] = []
        rig.operator.node.create_subscription(
            drivers.BridgeState, f'/{name}/robot_bridge/state', seen[name].append, drivers.RELIABLE
        )
        rig.processes('robot_bridge', namespace=f'/{name}', port=port, **CALM)
    rig.operator.until(lambda: all(seen.values()), 'states')
    time.sleep(6.0)
    for (_, states), port in zip(seen.items(), ports, strict=True):
        assert states[-1].controller == f'127.0.0.1:{port}'
        assert 'another node' not in states[-1].reason
        assert 'not active' not in states[-1].reason


@pytest.mark.slow
def test_names_are_watched_and_states_told_whatever_the_ros_clock_does(rig):
    """Nobody publishes /clock: by its time nothing would ever be due."""
    first = rig.cell(use_sim_time=True)
    operator = rig.connected(first)
    rig.cell()
    operator.until(
        lambda: any(state.controller == first.controller and 'another node' in state.reason
                    for state in operator.states[-20:]), 'clash',
    )  # fmt: skip
