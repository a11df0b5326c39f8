"""The package as ROS and pip see it."""

import ast
from functools import cache
from importlib import import_module
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
    'impact_testing',
    'machining',
    'modal_history',
    'modal_dashboard',
    'modal_recordings',
    'structural_model',
    'excitation_planner',
    'robot_bridge',
    'abb_emulator',
    'model_gap',
    'workspace_map',
    'autonomous_modal_analysis',
)
MIDDLEWARE = ('_node.py', 'ros_messages.py')
MIDDLEWARE_ENDS = tuple(name.removesuffix('.py') for name in MIDDLEWARE)


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
    from autonomous_modal_analysis.executables import NODES as EXECUTABLES
    from autonomous_modal_analysis.live.cell import NODES

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


OTHER_NAMES = {
    'google': 'python3-protobuf',
    'coal': 'pinocchio',
    'hppfcl': 'pinocchio',
    'markupsafe': 'python3-jinja2',
}
"""Modules that come with a package of another name."""
OWN_FOLDERS = {'test', 'benchmarks', 'examples', 'generated_pages'}


def foreign_modules(files) -> set[str]:
    """Return the modules that files import from neither Python nor this repository."""
    tops = {name.split('.')[0] for path in files for name in imported(path)}
    return tops - set(sys.stdlib_module_names) - {*ROOMS, *OWN_FOLDERS}


def stated(*kinds: str) -> set[str]:
    package = ElementTree.parse(ROOT / 'package.xml').getroot()
    return {item.text for kind in kinds for item in package.findall(kind)}


def from_pypi() -> set[str]:
    """Return what the README installs beside rosdep."""
    text = (ROOT / 'README.md').read_text()
    found = re.search(r'pip install --break-system-packages ([^`]+)`', text)
    return set(found[1].split())


def unstated(modules: set[str], keys: set[str]) -> set[str]:
    return {
        name for name in modules if not {name, f'python3-{name}', OTHER_NAMES.get(name)} & keys
    }


def test_package_xml_names_every_package_that_is_imported():
    files = [path for room in ROOMS for path in (ROOT / room).rglob('*.py')]
    modules = foreign_modules([*files, *(ROOT / 'launch').glob('*.py')])
    keys = stated('exec_depend')
    assert unstated(modules, keys | from_pypi()) == set()
    # And nothing twice, nor what nobody needs.
    assert not keys & from_pypi()
    known = {*modules, *(f'python3-{name}' for name in modules), *OTHER_NAMES.values()}
    assert keys - known == set()


def test_package_xml_names_what_tests_import():
    modules = foreign_modules((ROOT / 'test').rglob('*.py'))
    assert unstated(modules, stated('exec_depend', 'test_depend') | from_pypi()) == set()


def test_launch_and_command_line_move_the_emulated_arm_alike():
    from autonomous_modal_analysis.live.cell import BESIDE_EMULATOR

    module = ast.parse((ROOT / 'launch' / 'emulated_cell.launch.py').read_text())
    (value,) = [
        ast.literal_eval(node.value)
        for node in module.body
        if isinstance(node, ast.Assign) and node.targets[0].id == 'OF_EMULATED_CELL'
    ]
    assert value == {'robot_bridge': BESIDE_EMULATOR}


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
        'control_msgs',
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


@pytest.mark.parametrize('folder', ['benchmarks', 'examples', 'docs/generated_pages'])
def test_what_a_program_imports_when_it_runs_is_there(folder):
    """Imports inside functions too: nobody else would miss what moved."""
    for path in (ROOT / folder).rglob('*.py'):
        for node in ast.walk(ast.parse(path.read_text())):
            of = node.module if isinstance(node, ast.ImportFrom) else None
            if of is None or of.split('.')[0] not in ROOMS or of.endswith(MIDDLEWARE_ENDS):
                continue
            module = import_module(of)
            for name in (alias.name for alias in node.names):
                found = (
                    hasattr(module, name) or (ROOT / of.replace('.', '/') / f'{name}.py').exists()
                )
                assert found, f'{path.relative_to(ROOT)}:{node.lineno} imports {name} of {of}'


def test_arrows_between_rooms_point_one_way():
    allowed = {
        'modal_core': set(),
        'modal_recordings': {'modal_core'},
        'modal_reports': {'modal_core'},
        'oma_identifier': {'modal_core', 'modal_recordings'},
        'impact_testing': {'modal_core', 'modal_recordings', 'oma_identifier'},
        'machining': {'modal_core'},
        'modal_history': {'modal_core', 'oma_identifier', 'structural_model'},
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
        'modal_dashboard': {
            'modal_core',
            'modal_history',
            'modal_reports',
            'structural_model',
            'excitation_planner',
        },
        'workspace_map': {
            'machining',
            'modal_core',
            'modal_recordings',
            'modal_reports',
            'structural_model',
            'oma_identifier',
            'excitation_planner',
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


@cache
def imported(path: Path) -> tuple[str, ...]:
    """Return the full names of what a file imports, wherever in it."""
    names: list[str] = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [f'{node.module}.{alias.name}' for alias in node.names]
    return tuple(names)


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


FOLDED = (
    'oma_identifier',
    'excitation_planner',
    'model_gap',
    'modal_dashboard',
    'modal_recordings',
    'modal_reports',
    'robot_bridge',
    'abb_emulator',
    'impact_testing',
    'machining',
    'structural_model',
    'workspace_map',
)
"""Rooms whose folders show the method, and have doors."""


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


def test_no_files_import_one_another_in_a_circle():
    """Wherever in a file the import stands: a late one hides a circle and does not undo it."""
    files = {
        '.'.join(path.relative_to(ROOT).with_suffix('').parts): path
        for room in ROOMS
        for path in (ROOT / room).rglob('*.py')
        if path.name != '__init__.py'
    }
    arrows = {
        name: {
            target
            for found in imported(path)
            for target in (found, found.rpartition('.')[0])
            if target in files and target != name
        }
        for name, path in files.items()
    }
    while arrows:
        ends = {name for name, others in arrows.items() if not others & set(arrows)}
        assert ends, f'{sorted(arrows)} import one another in a circle, or what does'
        arrows = {name: others for name, others in arrows.items() if name not in ends}


def test_what_is_called_has_a_verb():
    """An object that is called as a function hides what it does."""
    for path in (file for room in ROOMS for file in (ROOT / room).rglob('*.py')):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef) and 'Protocol' not in map(ast.unparse, node.bases):
                named = [item.name for item in node.body if isinstance(item, ast.FunctionDef)]
                assert '__call__' not in named, f'{path.relative_to(ROOT)}: {node.name}'


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


@cache
def doors(folder: Path) -> list[str]:
    """Return the public names of a folder."""
    for node in ast.parse((folder / '__init__.py').read_text()).body:
        if isinstance(node, ast.Assign) and node.targets[0].id == '__all__':
            return ast.literal_eval(node.value)
    return []


@pytest.mark.parametrize('room', (*FOLDED, 'modal_core', 'autonomous_modal_analysis'))
def test_at_most_twelve_files_lie_flat(room):
    assert len(list((ROOT / room).glob('*.py'))) <= 12


@pytest.mark.parametrize('room', FOLDED)
def test_every_folder_says_what_comes_in_and_what_goes_out(room):
    for door in (ROOT / room).glob('*/__init__.py'):
        text = ast.get_docstring(ast.parse(door.read_text())) or ''
        assert 'n come' in text and 'out go' in text, door.relative_to(ROOT)
