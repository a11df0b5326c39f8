"""The package as ROS and pip see it."""

import ast
from pathlib import Path
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOMS = (
    'modal_core',
    'recordings',
    'oma_identifier',
    'structural_model',
    'excitation_planner',
    'robot_bridge',
    'model_gap',
    'autonomous_modal_analysis',
)
MIDDLEWARE = ('_node.py', 'ros_messages.py')


def setup_arguments() -> dict[str, ast.expr]:
    tree = ast.parse((ROOT / 'setup.py').read_text())
    call = next(
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and getattr(node.func, 'id', '') == 'setup'
    )
    return {keyword.arg: keyword.value for keyword in call.keywords if keyword.arg}


def executables() -> dict[str, str]:
    scripts = ast.literal_eval(setup_arguments()['entry_points'])['console_scripts']
    return dict(re.split(r'\s*=\s*', script, maxsplit=1) for script in scripts)


@pytest.mark.parametrize('field', ['version', 'description', 'license', 'maintainer'])
def test_setup_and_package_xml_say_the_same(field):
    package = ElementTree.parse(ROOT / 'package.xml').getroot()
    assert ast.literal_eval(setup_arguments()[field]) == package.findtext(field)


def test_every_executable_has_its_main():
    for target in executables().values():
        module, function = target.split(':')
        tree = ast.parse((ROOT / f'{module.replace(".", "/")}.py').read_text())
        assert any(
            isinstance(node, ast.FunctionDef) and node.name == function for node in tree.body
        )


def test_launch_files_name_executables_and_parameter_files_that_exist():
    files = list((ROOT / 'launch').glob('*.launch.py'))
    assert files
    for file in files:
        module = ast.parse(file.read_text())
        nodes = next(
            ast.literal_eval(node.value)
            for node in module.body
            if isinstance(node, ast.Assign) and node.targets[0].id == 'NODES'
        )
        for executable, _, parameters in nodes:
            assert executable in executables()
            assert (ROOT / 'config' / parameters).is_file()


def test_launch_and_command_line_start_the_same_nodes():
    from autonomous_modal_analysis.cell import NODES
    from autonomous_modal_analysis.executables import NODES as EXECUTABLES

    module = ast.parse((ROOT / 'launch' / 'emulated_cell.launch.py').read_text())
    launched = next(
        ast.literal_eval(node.value)
        for node in module.body
        if isinstance(node, ast.Assign) and node.targets[0].id == 'NODES'
    )
    started = tuple(
        (next(k for k, v in EXECUTABLES.items() if v == module_), name, file)
        for name, module_, file in NODES
    )
    assert started == launched


def test_core_imports_without_ros():
    modules = [
        '.'.join(path.relative_to(ROOT).with_suffix('').parts)
        for room in ROOMS
        for path in sorted((ROOT / room).rglob('*.py'))
        if not path.name.endswith(MIDDLEWARE) and path.name != '__init__.py'
    ]
    blocked = (
        'rclpy',
        'oma_msgs',
        'sensor_msgs',
        'geometry_msgs',
        'std_msgs',
        'trajectory_msgs',
        'visualization_msgs',
        'diagnostic_msgs',
        'builtin_interfaces',
    )
    code = f"""
import importlib, sys
for name in {blocked!r}:
    sys.modules[name] = None
for name in {modules!r}:
    importlib.import_module(name)
"""
    run = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert run.returncode == 0, run.stderr


def test_arrows_between_rooms_point_one_way():
    allowed = {
        'modal_core': set(),
        'recordings': {'modal_core'},
        'oma_identifier': {'modal_core', 'recordings'},
        'structural_model': {'modal_core'},
        'excitation_planner': {'modal_core', 'structural_model'},
        'robot_bridge': {'modal_core', 'recordings', 'structural_model', 'excitation_planner'},
        'model_gap': {
            'modal_core',
            'recordings',
            'structural_model',
            'oma_identifier',
            'excitation_planner',
        },
    }
    for room, may in allowed.items():
        for path in (ROOT / room).rglob('*.py'):
            for node in ast.walk(ast.parse(path.read_text())):
                names = []
                if isinstance(node, ast.Import):
                    names = [alias.name for alias in node.names]
                elif isinstance(node, ast.ImportFrom) and node.module:
                    names = [node.module]
                for name in names:
                    other = name.split('.')[0]
                    if other in ROOMS and other != room:
                        assert other in may, f'{path.relative_to(ROOT)} imports {name}'
