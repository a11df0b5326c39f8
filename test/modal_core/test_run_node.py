"""A node's process: what is wrong is one line, and no collection stops it for long."""

import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import pytest

from test.support.domains import ros_domain

pytest.importorskip('rclpy')
pytestmark = pytest.mark.node
IMPORT = 'from modal_core.nodes.run_node import run_node'


def run(code, *arguments, domain='0'):
    return subprocess.run(
        [
            sys.executable,
            '-c',
            f'from modal_core.nodes.run_node import run_node\n{code}',
            *arguments,
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env={**os.environ, 'ROS_DOMAIN_ID': domain},
    )


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (('--ros-args', '-p', 'a:b'), 'a:b'),
        (('--ros-args', '--params-file', '/none.yaml'), '/none.yaml'),
        (('--ros-args', '--no-such-option', 'x'), '--no-such-option'),
    ],
)
def test_a_bad_command_line_is_one_line_and_status_2(arguments, words):
    found = run("import rclpy; run_node('some', lambda: rclpy.create_node('some'))", *arguments)
    assert found.returncode == 2, found.stderr
    line = [text for text in found.stderr.splitlines() if text.startswith('some: ')]
    assert len(line) == 1 and words in line[0], found.stderr
    assert 'Traceback' not in found.stderr


def test_a_fault_of_the_program_is_not_hidden():
    found = run("run_node('some', lambda: 1 / 0)")
    assert found.returncode == 1
    assert 'ZeroDivisionError' in found.stderr


def test_no_request_ends_a_node():
    # Types of parameters that do not exist, and a transition that is not possible now.
    code = """
import rclpy
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode
bad = [Parameter(name='start_type_description_service', value=ParameterValue(type=99))]
activate = ChangeState.Request()
activate.transition.id = 3
def spin(node):
    asker, executor = rclpy.create_node('asker'), SingleThreadedExecutor()
    executor.add_node(node)
    executor.add_node(asker)
    for kind, name, request in (
        (SetParameters, 'set_parameters', SetParameters.Request(parameters=bad)),
        (
            SetParametersAtomically,
            'set_parameters_atomically',
            SetParametersAtomically.Request(parameters=bad),
        ),
        (ChangeState, 'change_state', activate),
    ):
        client = asker.create_client(kind, f'some/{name}')
        assert client.wait_for_service(60.0)
        answer = client.call_async(request)
        executor.spin_until_future_complete(answer, 60.0)
        assert answer.result() == kind.Response(), answer.result()
run_node('some', lambda: LifecycleNode('some'), spin)
"""
    found = run(code, domain=str(ros_domain()))
    assert found.returncode == 0, found.stderr
    told = [line for line in found.stderr.splitlines() if 'cannot be answered' in line]
    assert len(told) == 3 and '99' in told[0] and 'some/change_state' in told[2], found.stderr


def test_libraries_are_not_taken_apart_at_the_end():
    # What runs after the interpreter's end aborts, as the middleware's own did with threads left.
    code = """
import ctypes, rclpy
libraries = ctypes.CDLL(None)
getattr(libraries, '__cxa_atexit')(ctypes.cast(libraries.abort, ctypes.c_void_p), None, None)
print('said', end='')
run_node('some', lambda: rclpy.create_node('some'), lambda node: None)
"""
    found = run(code)
    assert (found.returncode, found.stdout) == (0, 'said'), found.stderr


def test_a_running_node_collects_only_what_came_since():
    code = """
import gc, rclpy, numpy
def spin(node):
    print(gc.get_freeze_count(), gc.get_count())
run_node('some', lambda: rclpy.create_node('some'), spin)
"""
    found = run(code)
    assert found.returncode == 0, found.stderr
    assert int(found.stdout.split()[0]) > 20_000


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('place', ['make', 'spin'])
def test_a_signal_ends_long_work_at_once_and_quietly(number, place):
    # Ten minutes of work in Python: only the signal can end it.
    code = f"""
import signal, time, rclpy
from modal_core.nodes.run_node import run_node
signal.signal(signal.SIGINT, signal.default_int_handler)
def work(*_):
    print('working', flush=True)
    for _ in range(60_000):
        time.sleep(0.01)
def make():
    node = rclpy.create_node('some')
    if {place == 'make'}:
        work()
    return node
run_node('some', make, work)
"""
    process = subprocess.Popen(
        [sys.executable, '-c', code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == 'working\n'
    process.send_signal(number)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    assert 'Traceback' not in errors


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_that_python_drops_ends_a_node_all_the_same(number):
    # A shell without job control starts processes that ignore interrupts.
    code = f"""
import signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)
class Last:
    def __del__(self):
        signal.raise_signal({number:d})
def make():
    Last()
    for _ in range(60_000):
        time.sleep(0.01)
run_node('some', make)
"""
    found = run(code)
    assert (found.returncode, found.stderr) == (0, '')


@pytest.mark.parametrize('asked', ['rclpy.ok', 'interrupted'])
def test_what_a_stopped_middleware_refuses_is_no_fault(asked):
    # The signal's interrupt may come while it is asked whether there was a signal.
    code = f"""
import rclpy
from std_msgs.msg import Empty
def interrupted():
    raise KeyboardInterrupt
def spin(node):
    publisher = node.create_publisher(Empty, 'topic', 1)
    rclpy.shutdown()
    rclpy.ok = {asked}
    publisher.publish(Empty())
run_node('some', lambda: rclpy.create_node('some'), spin)
"""
    found = run(code)
    assert (found.returncode, found.stderr) == (0, '')


def test_an_object_that_was_half_made_ends_without_a_word():
    code = """
class Half:
    def __del__(self):
        self.never_set
class Whole:
    def __del__(self):
        1 / 0
def spin(node):
    Half()
    Whole()
run_node('some', lambda: __import__('rclpy').create_node('some'), spin)
"""
    found = run(code)
    assert found.returncode == 0
    assert 'ZeroDivisionError' in found.stderr and 'never_set' not in found.stderr


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_leaves_no_node_half_taken_down(number):
    code = f"""
import signal, rclpy
from rclpy.node import Node
class Some(Node):
    def destroy_node(self):
        signal.raise_signal({number:d})
        super().destroy_node()
        print('taken down', flush=True)
run_node('some', lambda: Some('some'), lambda node: signal.raise_signal({number:d}))
"""
    found = run(code)
    assert (found.returncode, found.stdout, found.stderr) == (0, 'taken down\n', '')


@pytest.mark.parametrize('stuck', ['taking_down', 'a_thread', 'the_last'])
def test_nothing_stuck_keeps_a_process(stuck):
    # In C and with the interpreter's lock held, as a destructor of the middleware would.
    code = f"""
import atexit, ctypes, rclpy, threading
from rclpy.node import Node
from modal_core.nodes import run_node as life
life.ENDING_S = 1
held = ctypes.PyDLL(None)
class Some(Node):
    def destroy_node(self):
        if {stuck == 'taking_down'}:
            held.pause()
        super().destroy_node()
if {stuck == 'a_thread'}:
    threading.Thread(target=threading.Event().wait).start()
def spin(node):
    if {stuck == 'the_last'}:
        atexit.register(held.pause)
life.run_node('some', lambda: Some('some'), spin)
"""
    found = run(code)
    # At the last two clocks run, of the interpreter and of the system.
    ends = (1, -signal.SIGALRM) if stuck == 'the_last' else (1,)
    assert found.returncode in ends, found.stderr
    if stuck == 'taking_down':
        assert 'in destroy_node' in found.stderr


def is_running(pid):
    try:
        state = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != 'Z'  # of a process whose new parent has not looked after it yet


def test_nodes_end_with_the_command_that_started_them_however_it_ends():
    starter = """
import time
from autonomous_modal_analysis.live.processes import NodeCommand, NodeProcesses
with NodeProcesses([NodeCommand('arm_state', 'robot_bridge.node.arm_state_node')]):
    print('started', flush=True)
    time.sleep(600)
"""
    process = subprocess.Popen([sys.executable, '-c', starter], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == 'started\n'
    children = Path(f'/proc/{process.pid}/task/{process.pid}/children')
    node = int(children.read_text())
    environment = Path(f'/proc/{node}/environ')
    deadline_s = time.monotonic() + 60.0
    while b'AMA_STARTED_BY' not in environment.read_bytes():
        assert time.monotonic() < deadline_s
    process.kill()
    process.wait()
    while is_running(node):
        assert time.monotonic() < deadline_s, 'the node is left'
        time.sleep(0.05)
