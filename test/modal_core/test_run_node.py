"""A node's process: what is wrong is one line, and no collection stops it for long."""

import subprocess
import sys

import pytest

pytest.importorskip('rclpy')
pytestmark = pytest.mark.node


def run(code, *arguments):
    return subprocess.run(
        [sys.executable, '-c', f'from modal_core.run_node import run_node\n{code}', *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
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
