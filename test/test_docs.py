"""The documentation names what there is, and its commands and examples work."""

import ast
from functools import cache
import json
import os
from pathlib import Path
import re
import shlex
import subprocess
import sys

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / 'docs')]

from generated_pages.commands import commands_page  # noqa: E402
from generated_pages.effects import effects_page  # noqa: E402
from generated_pages.imports import arrows_between_rooms, arrows_within  # noqa: E402
from generated_pages.messages import messages_page  # noqa: E402
from generated_pages.mode import mode_page  # noqa: E402
from generated_pages.modules import module_pages  # noqa: E402
from generated_pages.parameters import node_parameters, parameters_page  # noqa: E402
from generated_pages.picture import svg  # noqa: E402
from generated_pages.place import rooms  # noqa: E402

from test.support.docs_pages import anchors, blocks, blocks_of, DOCS, pages  # noqa: E402

INTERFACES = sorted((ROOT / 'oma_msgs').glob('msg/*.msg')) + sorted(
    (ROOT / 'oma_msgs').glob('srv/*.srv')
)
PAGES = pages()
GAP_PAGE = DOCS / 'tutorial' / 'first_gap.md'


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def fields(path: Path) -> list[str]:
    lines = [line.split('#')[0].strip() for line in path.read_text().splitlines()]
    return [line.split()[1] for line in lines if line and line != '---' and '=' not in line]


# -- what is made from the code ------------------------------------------------------------------


@pytest.mark.parametrize('path', INTERFACES, ids=lambda path: path.stem)
def test_every_field_of_a_message_is_documented_with_its_comment(path):
    page = messages_page()
    section = page.split(f'### oma_msgs/{path.stem}\n')[1].split('\n### ')[0]
    for field in fields(path):
        (row,) = [line for line in section.splitlines() if line.startswith(f'| `{field}` ')]
        assert row.split('|')[3].strip(), f'{path.name}: {field} says nothing'
    assert path.stem in (DOCS / 'reference' / 'topics.md').read_text()


@pytest.mark.parametrize('path', INTERFACES, ids=lambda path: path.stem)
def test_every_field_carries_a_comment(path):
    lines = path.read_text().splitlines()
    assert lines[0].startswith('# ')
    bare = [
        line
        for line in lines
        if line and not line.startswith('#') and line != '---' and '#' not in line
    ]
    assert not bare


def test_every_interface_is_built():
    cmake = (ROOT / 'oma_msgs' / 'CMakeLists.txt').read_text()
    for path in INTERFACES:
        assert f'"{path.parent.name}/{path.name}"' in cmake


def test_every_command_and_option_is_documented():
    """Against what the commands themselves print."""
    from typer.testing import CliRunner

    from autonomous_modal_analysis.cli import app

    page = commands_page()
    wide = {'env': {'COLUMNS': '400', 'TERM': 'dumb', 'NO_COLOR': '1'}}
    listed = CliRunner().invoke(app, ['--help'], **wide).output
    names = set(re.findall(r'^\W*([a-z]+)  ', listed.split('Commands')[1], re.M))
    assert {'identify', 'plan', 'gap'} <= names
    for name in names:
        section = page.split(f'## ama {name}\n')[1].split('\n## ')[0]
        shown = CliRunner().invoke(app, [name, '--help'], **wide).output
        for option in set(re.findall(r'(--[a-z][a-z0-9-]+)', shown)) - {'--help'}:
            assert option in section, f'ama {name} {option}'


@pytest.mark.node
@pytest.mark.parametrize('executable', list(node_parameters()))
def test_parameters_are_those_a_node_declares(executable, tmp_path):
    """A real node of each kind, asked for its parameters as `ros2 param list` does."""
    code = f"""
import importlib, json, rclpy
from rclpy.parameter import Parameter
from autonomous_modal_analysis.executables import NODES
module = importlib.import_module(NODES[{executable!r}])
(kind,) = [k for k in vars(module).values()
           if isinstance(k, type) and issubclass(k, rclpy.node.Node)
           and k.__module__ == module.__name__]
rclpy.init()
overrides = {{'replay': [Parameter('recording', value={str(tmp_path / 'r.npy')!r}),
    Parameter('sample_rate_hz', value=100.0), Parameter('unit', value='m/s^2'),
    Parameter('channels', value=['a'])], 'robot_bridge': [Parameter('autostart', value=False)]}}
options = {{'parameter_overrides': overrides.get({executable!r}, [])}}
node = kind(**options)
print('DECLARED', json.dumps({{name: node.describe_parameter(name).description
                  for name in node._parameters if name != 'use_sim_time'}}), flush=True)
import os; os._exit(0)
"""
    import numpy as np

    np.save(tmp_path / 'r.npy', np.zeros((1000, 1)))
    ended = subprocess.run(
        [sys.executable, '-c', code],
        capture_output=True,
        text=True,
        timeout=120,
        cwd=ROOT,
        env={**os.environ, 'ROS_DOMAIN_ID': '87'},
        check=False,
    )
    lines = [line for line in ended.stdout.splitlines() if line.startswith('DECLARED ')]
    assert lines, ended.stderr
    declared = json.loads(lines[0].removeprefix('DECLARED '))
    # Middleware adds some of its own, without a description or with a prefix.
    own = {name for name in declared if not name.startswith('qos_overrides')}
    documented = {row.name: row.text for row in node_parameters()[executable]}
    assert set(documented) == own - {'start_type_description_service'}
    assert all(declared[name] == text for name, text in documented.items())
    assert all(f'| `{name}` |' in parameters_page() for name in documented)


def test_every_field_of_a_mode_is_documented():
    from modal_core.mode import MODE_FIELDS, MODE_KEYS

    page = mode_page()
    assert all(f'`{key}`' in page for key in MODE_KEYS)
    assert all(item.text and item.text in page for item in MODE_FIELDS)


def test_every_effect_is_documented():
    from model_gap.effects import CATALOGUE

    page = effects_page()
    for effect in CATALOGUE:
        assert f'## {effect.type}\n' in page
        assert effect.equation in page


def test_every_module_is_in_the_reference():
    text = '\n'.join(written_pages().values())
    for room in rooms():
        for path in (ROOT / room).rglob('*.py'):
            dotted = '.'.join(path.relative_to(ROOT).with_suffix('').parts)
            if path.name not in ('__init__.py', '__main__.py'):
                assert f'.. automodule:: {dotted}\n' in text, dotted


def test_the_picture_shows_the_imports_there_are():
    """Each arrow against a search for import lines, by the interpreter's own parser."""
    arrows = arrows_between_rooms()
    assert set(arrows) == set(rooms())
    for room, others in arrows.items():
        lines = ''.join(path.read_text() for path in (ROOT / room).rglob('*.py'))
        for other in set(rooms()) - {room}:
            found = re.search(rf'^\s*(from|import) {other}\b', lines, re.M) is not None
            assert (other in others) == found, f'{room} -> {other}'
    for picture in (arrows, arrows_within('oma_identifier'), arrows_within('model_gap')):
        drawn = svg(picture, 'title')
        for part in picture:
            assert f'>{part.rsplit(".", 1)[-1]}<' in drawn
        for page in re.findall(r'href="\.\./reference/generated/modules/(.+?)\.html"', drawn):
            assert f'{page}.rst' in written_pages()


# -- what is written by hand ---------------------------------------------------------------------


@cache
def written_pages():
    """Return the pages of the modules; every link asks for them."""
    return module_pages()


@pytest.mark.parametrize('page', PAGES, ids=name_of)
def test_links_lead_somewhere(page):
    """To a file that exists, and to a heading that exists in it."""
    text = re.sub(r'```.*?```', '', page.read_text(), flags=re.S)
    for target in re.findall(r'\]\(([^)\s]+)\)', text):
        if target.startswith(('http', 'mailto', 'file:')):
            continue
        place, _, anchor = target.partition('#')
        path = (page.parent / place).resolve() if place else page
        if 'generated' in path.parts:
            made = path.relative_to(DOCS / 'reference' / 'generated')
            assert made.parts[0] == 'modules' and made.name in written_pages(), target
            continue
        assert path.exists(), f'{page.name}: {target}'
        if anchor:
            assert anchor in anchors(path), f'{page.name}: {target}'


@pytest.mark.parametrize('page', PAGES, ids=name_of)
def test_files_that_are_named_exist(page):
    own = (*rooms(), 'test', 'benchmarks', 'config', 'examples', 'launch', 'docs')
    for named in re.findall(r'`([\w./]+/[\w./]*)`', page.read_text()):
        made = named.startswith('docs/_build/')  # by `make docs`
        if named.split('/')[0] in own and not named.endswith('my_robot') and not made:
            assert (ROOT / named).exists(), f'{page.name}: {named}'


def test_every_page_is_in_a_table_of_contents():
    """Sphinx says so as well, but only where it is installed."""
    listed = {DOCS / 'index.md'}
    for page in PAGES:
        for block in blocks(page):
            if block.language == '{toctree}':
                lines = [line for line in block.text.splitlines() if not line.startswith(':')]
                listed |= {page.parent / f'{line.strip()}.md' for line in lines if line.strip()}
    assert {page for page in PAGES if DOCS in page.parents} <= listed


def commands() -> list[str]:
    found = []
    for block in blocks_of('', 'sh', 'bash', 'shell'):
        for line in block.text.splitlines():
            if line.strip().startswith('ama ') and '...' not in line and '<' not in line:
                found.append(line.split('  #')[0].strip())
    return sorted(set(found))


@pytest.mark.parametrize('line', commands())
def test_commands_of_the_documents_have_these_options(line):
    """Unknown commands and options are refused before any help is shown."""
    from typer.testing import CliRunner

    from autonomous_modal_analysis.cli import app

    words = shlex.split(line.partition(' > ')[0])[1:]
    run = CliRunner().invoke(app, [*words, '--help'])
    assert run.exit_code == 0, run.output
    wrong = CliRunner().invoke(app, [*words, '--no-such-option', '--help'])
    assert wrong.exit_code == 2


def make_targets() -> list[str]:
    return sorted(
        {
            target
            for block in blocks_of('', 'sh')
            for target in re.findall(r'^\s*make ([a-z-]+)', block.text, re.M)
        }
    )


@pytest.mark.parametrize('target', make_targets())
def test_targets_of_make_exist(target):
    assert re.search(rf'^{target}:', (ROOT / 'Makefile').read_text(), re.M)


@pytest.mark.parametrize('block', blocks_of('yaml'), ids=str)
def test_yaml_of_the_documents_can_be_read(block):
    if 'sensors: [...]' not in block.text:
        assert yaml.safe_load(block.text)


@pytest.mark.parametrize('block', blocks_of('python'), ids=str)
def test_python_of_the_documents_runs(block, tmp_path):
    ast.parse(block.text)
    ended = subprocess.run(
        [sys.executable, '-c', block.text],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, 'PYTHONPATH': str(ROOT)},
        check=False,
    )
    assert ended.returncode == 0, ended.stderr


def test_the_first_recording_gives_the_modes_the_tutorial_names(tmp_path):
    """The page's own file by the page's own command, seed 5."""
    page = DOCS / 'tutorial' / 'first_recording.md'
    (code,) = [block for block in blocks(page) if block.language == 'python']
    (sidecar,) = [block for block in blocks(page) if block.language == 'yaml']
    run = {'cwd': tmp_path, 'env': {**os.environ, 'PYTHONPATH': str(ROOT)}, 'check': True}
    subprocess.run([sys.executable, '-c', code.text], **run)
    (tmp_path / 'tower.csv.yaml').write_text(sidecar.text)
    ama = [sys.executable, '-m', 'autonomous_modal_analysis']
    ended = subprocess.run(
        [*ama, 'identify', 'tower.csv', '--json'], capture_output=True, text=True, **run
    )
    modes = json.loads(ended.stdout)['modes']
    assert [round(mode['frequency_hz']) for mode in modes] == [11, 27]
    for mode, damping in zip(modes, (0.02, 0.015), strict=True):
        assert abs(mode['damping_ratio'] - damping) < 3.0 * mode['damping_ratio_std']


def test_only_rooms_that_exist_are_named_in_the_readme():
    readme = (ROOT / 'README.md').read_text()
    for folder in re.findall(r'`([a-z_]+)/`', readme):
        exists = (ROOT / folder).is_dir() or list(ROOT.glob(f'*/{folder}'))
        assert exists or folder == 'ama_demo', folder


def test_every_fault_has_a_test_that_exists():
    rows = [
        line
        for line in (DOCS / 'reference' / 'faults.md').read_text().splitlines()
        if line.startswith('|') and not line.startswith(('| fault', '|---'))
    ]
    for row in rows:
        named = re.findall(r'`(test/[^`:]+)::(\w+)`', row)
        assert named, f'no test named in: {row}'
        for file, test in named:
            assert f'def {test}(' in (ROOT / file).read_text(), f'{file}::{test}'


def test_arm_of_the_first_gap_is_one_the_emulator_takes():
    from abb_emulator.run_plan import ArmOptions

    text = GAP_PAGE.read_text()
    block = text.split('```yaml\n')[1].split('```')[0]
    (effect,) = ArmOptions.from_mapping(yaml.safe_load(block)).cell.effects
    assert (effect.type, effect.place) == ('joint_stiffness', 'joint_2')
