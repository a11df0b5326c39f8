"""What an install holds and says where a part is missing; .ci/installed installs the wheels."""

import ast
from pathlib import Path
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from autonomous_modal_analysis.executables import NODES
from autonomous_modal_analysis.live.cell import NODES as CELL
from autonomous_modal_analysis.missing import explain, ROS
from modal_core.measurements import SampleBlock
from modal_recordings import RecordingWriter
from modal_recordings.messages import encode
from test.test_package import executables, ROOMS, ROOT, setup_arguments

OWN_MESSAGES = {'oma_msgs', 'tf2_msgs', 'control_msgs'}
DEFINITIONS = 'modal_recordings/oma_msgs_definitions'
# Modules whose distribution, or package of ROS, has another name.
DISTRIBUTIONS = {
    'coal': 'pin',
    'google': 'protobuf',
    'hppfcl': 'pin',
    'pinocchio': 'pin',
    'yaml': 'pyyaml',
}
ROS_KEYS = {'coal': 'pinocchio', 'google': 'python3-protobuf', 'hppfcl': 'pinocchio'}
# Brought along by another package that is declared.
BROUGHT_ALONG = {'apsw': 'rosbags', 'lz4': 'mcap', 'markupsafe': 'jinja2', 'zstandard': 'mcap'}


@pytest.fixture(scope='module')
def installed(tmp_path_factory) -> Path:
    """Return a folder with what a plain install puts into site-packages."""
    place = tmp_path_factory.mktemp('installed')
    target = place / 'site-packages'
    subprocess.run(
        [
            sys.executable, 'setup.py', '--quiet', 'build',
            '--build-base', place / 'build', '--build-lib', target,
        ],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )  # fmt: skip
    return target


def run_installed(installed: Path, code: str, *arguments: object):
    """Run Python with the installed code first on the path, away from the source tree."""
    return subprocess.run(
        [sys.executable, '-c', f'import sys; sys.path.insert(0, {str(installed)!r})\n{code}']
        + [str(argument) for argument in arguments],
        cwd=installed.parent,
        capture_output=True,
        text=True,
        check=False,
    )


def test_shipped_definitions_are_those_the_messages_are_built_from(installed):
    source = {file.name: file.read_text() for file in (ROOT / 'oma_msgs' / 'msg').glob('*.msg')}
    shipped = {file.name: file.read_text() for file in (installed / DEFINITIONS).iterdir()}
    assert source and shipped == source


@pytest.mark.parametrize('messages', ['missing', 'installed'])
def test_an_install_reads_blocks(installed, messages, tmp_path):
    if messages == 'installed':
        # The Python code of the messages lies beside the suite and is no folder of definitions.
        package = installed / 'oma_msgs' / 'msg'
        package.mkdir(parents=True, exist_ok=True)
        (package / '__init__.py').touch()
    path = tmp_path / 'blocks.mcap'
    values = np.random.default_rng(3).normal(size=(400, 2)).astype(np.float32)
    with RecordingWriter(path) as writer:
        block = SampleBlock('/acceleration_block', 10**18, 0, 200.0, ('a', 'b'), values)
        for message in encode(block, '/acceleration_block'):
            writer.write(message.topic, message.message_type, message.log_time_ns, message.data)
    code = (
        'import modal_recordings\n'
        f'assert modal_recordings.__file__.startswith({str(installed)!r})\n'
        'recording = modal_recordings.open_recording(sys.argv[1])\n'
        'print(sum(part.acceleration.sum() for part in recording.measurements()))'
    )
    ended = run_installed(installed, code, path)
    assert ended.returncode == 0, ended.stderr
    assert float(ended.stdout) == pytest.approx(float(values.sum()), rel=1e-5)


# None in sys.modules is what Python itself has for "not there".
WITHOUT = 'for name in {missing}: sys.modules[name] = None\n'


@pytest.mark.parametrize(
    ('missing', 'advice'),
    [(sorted((*ROS, 'oma_msgs')), 'ros-jazzy-rclpy'), (['oma_msgs'], 'pip install ./oma_msgs')],
    ids=['ros', 'messages'],
)
@pytest.mark.parametrize('name', ['ama up', 'ama demo', *NODES])
def test_what_needs_ros_says_what_to_install(installed, name, missing, advice):
    if 'rclpy' not in missing:
        pytest.importorskip('rclpy')
    program, *arguments = name.split()
    module, function = executables()[program].split(':')
    code = (
        WITHOUT.format(missing=missing)
        + f'sys.argv = {[program, *arguments]!r}\n'
        + f'from {module} import {function}\n{function}()'
    )
    ended = run_installed(installed, code)
    assert ended.returncode == 2, ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1, ended.stderr
    assert advice in ended.stderr


@pytest.mark.parametrize('name', ['ama up', 'ama demo', 'ama replay x.mcap', *NODES])
def test_messages_of_another_version_are_told(installed, name):
    """As after an update of the suite alone."""
    pytest.importorskip('rclpy')
    program, *arguments = name.split()
    module, function = executables()[program].split(':')
    older = installed / DEFINITIONS / 'Mode.msg'
    text = older.read_text()
    older.write_text(f'{text}float64 modal_mass_kg   # added by the update\n')
    try:
        ended = run_installed(
            installed,
            f'sys.argv = {[program, *arguments]!r}\nfrom {module} import {function}\n{function}()',
        )
    finally:
        older.write_text(text)
    assert ended.returncode == 2, ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1, ended.stderr
    assert 'modal_mass_kg' in ended.stderr and 'pip install ./oma_msgs' in ended.stderr


def test_a_source_tree_without_its_messages_says_so(tmp_path):
    """There the folder of definitions is importable, and empty."""
    code = (
        'import importlib.machinery, sys\n'
        'class Hide:\n'
        '    def find_spec(self, name, path=None, target=None):\n'
        '        if name != "oma_msgs":\n'
        '            return None\n'
        f'        return importlib.machinery.PathFinder.find_spec(name, [{str(ROOT)!r}])\n'
        'sys.meta_path.insert(0, Hide())\n'
        f'sys.path.insert(0, {str(ROOT)!r})\n'
        'sys.argv = ["ama", "up"]\n'
        'from autonomous_modal_analysis.__main__ import main; main()'
    )
    pytest.importorskip('rclpy')
    ended = subprocess.run(
        [sys.executable, '-c', code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (ended.returncode, len(ended.stderr.strip().splitlines())) == (2, 1), ended.stderr
    assert 'pip install ./oma_msgs' in ended.stderr


def test_a_missing_python_package_is_one_line(tmp_path):
    code = (
        f'import sys; sys.path.insert(0, {str(ROOT)!r}); sys.modules["typer"] = None\n'
        'from autonomous_modal_analysis.__main__ import main; main()'
    )
    ended = subprocess.run(
        [sys.executable, '-c', code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (ended.returncode, len(ended.stderr.strip().splitlines())) == (2, 1), ended.stderr
    assert 'typer' in ended.stderr and 'pip install' in ended.stderr


def test_code_in_the_folder_one_stands_in_is_not_run(tmp_path):
    from autonomous_modal_analysis.live.processes import NodeCommand

    (tmp_path / 'numpy.py').write_text('raise SystemExit("not numpy")\n')
    line = NodeCommand('node', 'modal_core.numbers.indicators').arguments()
    ended = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr


def test_executables_are_the_nodes_of_the_cell():
    assert {program for program in executables() if program != 'ama'} == set(NODES)
    assert {name: module for name, module, _ in CELL}.items() <= NODES.items()


def imported() -> set[str]:
    """Return the top-level modules that the code imports and Python does not bring."""
    found = set()
    for room in ROOMS:
        for path in (ROOT / room).rglob('*.py'):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.Import):
                    found |= {alias.name.partition('.')[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and node.module:
                    found.add(node.module.partition('.')[0])
    return found - set(sys.stdlib_module_names) - set(ROOMS)


def test_every_import_is_declared_to_pip():
    lines = ast.literal_eval(setup_arguments()['install_requires'])
    declared = {re.split(r'[<>=\[]', line)[0] for line in lines}
    needed = {DISTRIBUTIONS.get(name, name) for name in imported() - ROS - OWN_MESSAGES}
    assert needed <= declared
    assert {name for name in imported() if name.endswith('_msgs')} <= ROS | OWN_MESSAGES


def test_every_import_is_declared_to_ros_or_named_in_the_readme():
    package = ElementTree.parse(ROOT / 'package.xml').getroot()
    declared = {entry.text for entry in package.iter('exec_depend')}
    readme = (ROOT / 'README.md').read_text()
    line = re.search(r'pip install --break-system-packages ([\w\s]+)', readme)
    by_hand = line.group(1).split()
    # rosdep has keys for neither these nor what they bring along.
    for name in imported():
        name = BROUGHT_ALONG.get(name, name)
        keys = {name, f'python3-{name}', ROS_KEYS.get(name, name)}
        assert keys & declared or name in by_hand, name


def test_a_library_of_ros_that_cannot_be_loaded_is_one_line():
    # As where ROS is installed and its set-up was not sourced; rclpy adds lines of its own.
    told = explain(ImportError('librcl_action.so: cannot open shared object file\nThe C ...'))
    assert told is not None and 'librcl_action.so' in str(told) and 'setup.bash' in str(told)
    assert 'The C' not in str(told)
    assert explain(ImportError("cannot import name 'x'")) is None
