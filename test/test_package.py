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
    'modal_recordings',
    'modal_reports',
    'oma_identifier',
    'structural_model',
    'excitation_planner',
    'robot_bridge',
    'abb_emulator',
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
        'modal_recordings': {'modal_core'},
        'modal_reports': {'modal_core'},
        'oma_identifier': {'modal_core', 'modal_recordings'},
        'structural_model': {'modal_core'},
        'excitation_planner': {'modal_core', 'structural_model'},
        'robot_bridge': {
            'modal_core',
            'modal_recordings',
            'structural_model',
            'excitation_planner',
        },
        'abb_emulator': {
            'modal_core',
            'modal_recordings',
            'structural_model',
            'excitation_planner',
            'robot_bridge',
        },
        'model_gap': {
            'modal_core',
            'modal_recordings',
            'modal_reports',
            'structural_model',
            'oma_identifier',
            'excitation_planner',
        },
    }
    for room, may in allowed.items():
        for path in (ROOT / room).rglob('*.py'):
            for name in imported(path):
                other = name.split('.')[0]
                if other in ROOMS and other != room:
                    assert other in may, f'{path.relative_to(ROOT)} imports {name}'


def imported(path: Path) -> list[str]:
    """Return the full names of what a file imports, wherever in it."""
    names = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [f'{node.module}.{alias.name}' for alias in node.names]
    return names


def test_tests_reach_for_no_private_name():
    """Tests hold for behaviour: what has a name with an underscore may change any day."""
    found = [
        f'{path.relative_to(ROOT)}:{line} {name}'
        for path in sorted((ROOT / 'test').rglob('*.py'))
        for line, name in private_uses(ast.parse(path.read_text()))
    ]
    assert found == []


def test_no_test_measures_time():
    """A busy machine is slow and not wrong: `make bench` measures, tests count work."""
    clocks = re.compile(r'\b(perf_counter|process_time|thread_time)(_ns)?\b')
    for path in sorted((ROOT / 'test').rglob('*.py')):
        used = [line for line in path.read_text().splitlines() if clocks.search(line)]
        assert path == Path(__file__) or not used, f'{path.relative_to(ROOT)}: {used}'


def private_uses(tree: ast.Module) -> list[tuple[int, str]]:
    """Return line and name of each underscored name that a file takes from elsewhere."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and getattr(node.value, 'id', '') not in OWN:
            found.append((node.lineno, node.attr))
        elif isinstance(node, ast.ImportFrom):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.Call) and 'attr' in getattr(
            node.func, 'attr', getattr(node.func, 'id', '')
        ):  # getattr, setattr, monkeypatch.setattr, patch.object's kin
            texts = [item.value for item in node.args if isinstance(item, ast.Constant)]
            found += [(node.lineno, text) for text in texts if isinstance(text, str)]
    return [(line, name) for line, name in found if is_private(name)]


OWN = ('self', 'cls')


def is_private(name: str) -> bool:
    """Two underscores are Python's own names, ``_repr_*_`` are notebooks'."""
    return bool(re.fullmatch(r'_(?!_|repr_)\w+', name))


@pytest.mark.parametrize(
    'text',
    ['a._b', 'a.b._c()', 'from a import _b', "setattr(a, '_b', 1)", "m.setattr(a, '_b', 1)"],
)
def test_a_private_name_is_seen(text):
    assert [name for _, name in private_uses(ast.parse(text))] != []


@pytest.mark.parametrize('text', ['self._b', 'cls._b', 'a.__doc__', 'a._repr_html_()', '_ = a.b'])
def test_a_name_of_ones_own_is_not(text):
    assert private_uses(ast.parse(text)) == []


FOLDED = ('oma_identifier', 'model_gap', 'modal_reports', 'robot_bridge', 'abb_emulator')
"""Rooms whose folders show the method."""


def folder_of(room: str, parts: tuple[str, ...]) -> str:
    """Return the folder of a module in a room, or the module itself where it lies flat."""
    return parts[0] if (ROOT / room / parts[0]).is_dir() else f'{parts[0]}.py'


def arrows_inside(room: str) -> dict[str, set[str]]:
    """Return which folders (and flat files) of a room import which others."""
    arrows: dict[str, set[str]] = {}
    for path in (ROOT / room).rglob('*.py'):
        here = path.relative_to(ROOT / room)
        if here == Path('__init__.py'):
            continue
        mine = folder_of(room, here.with_suffix('').parts)
        others = arrows.setdefault(mine, set())
        for name in imported(path):
            of, *parts = name.split('.')
            if of == room and folder_of(room, tuple(parts)) != mine:
                others.add(folder_of(room, tuple(parts)))
    return arrows


@pytest.mark.parametrize('room', FOLDED)
def test_arrows_inside_a_room_make_no_circle(room):
    arrows = arrows_inside(room)
    while arrows:
        ends = {name for name, others in arrows.items() if not others & set(arrows)}
        assert ends, f'{room}: {sorted(arrows)} import one another in a circle'
        arrows = {name: others for name, others in arrows.items() if name not in ends}


@pytest.mark.parametrize('room', FOLDED)
def test_folders_are_entered_by_their_doors(room):
    """Other folders import what a folder's ``__init__.py`` lists, and nothing behind it."""
    for path in (file for each in ROOMS for file in (ROOT / each).rglob('*.py')):
        for name in imported(path):
            of, *parts = name.split('.')
            folder = ROOT / room / parts[0] if of == room and parts else None
            if folder is None or not folder.is_dir() or path.is_relative_to(folder):
                continue
            if parts[1].endswith(('_node', 'ros_messages')):
                continue  # middleware: a door that imported it would ask ROS of everyone
            assert parts[1] in doors(folder), f'{path.relative_to(ROOT)} imports {name}'


def doors(folder: Path) -> list[str]:
    """Return the public names of a folder."""
    for node in ast.parse((folder / '__init__.py').read_text()).body:
        if isinstance(node, ast.Assign) and node.targets[0].id == '__all__':
            return ast.literal_eval(node.value)
    return []


@pytest.mark.parametrize('room', FOLDED)
def test_at_most_twelve_files_lie_flat(room):
    assert len(list((ROOT / room).glob('*.py'))) <= 12


@pytest.mark.parametrize('room', FOLDED)
def test_every_folder_says_what_comes_in_and_what_goes_out(room):
    for door in (ROOT / room).glob('*/__init__.py'):
        text = ast.get_docstring(ast.parse(door.read_text())) or ''
        assert 'n come' in text and 'out go' in text, door.relative_to(ROOT)
