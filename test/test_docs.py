"""The documentation names what there is."""

from pathlib import Path
import re
import shlex

import pytest

ROOT = Path(__file__).resolve().parents[1]
INTERFACES = sorted((ROOT / 'oma_msgs').glob('msg/*.msg')) + sorted(
    (ROOT / 'oma_msgs').glob('srv/*.srv')
)


def fields(path: Path) -> list[str]:
    lines = [line.split('#')[0].strip() for line in path.read_text().splitlines()]
    return [line.split()[1] for line in lines if line and line != '---' and '=' not in line]


@pytest.mark.parametrize('path', INTERFACES, ids=lambda path: path.stem)
def test_every_field_of_a_message_is_documented(path):
    text = (ROOT / 'docs' / 'reference' / 'topics.md').read_text()
    assert path.stem in text
    for field in fields(path):
        assert f'`{field}`' in text, f'{path.name}: {field}'


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


def test_links_between_documents_lead_somewhere():
    for page in [ROOT / 'README.md', *sorted((ROOT / 'docs').rglob('*.md'))]:
        for target in re.findall(r'\]\(([^)#]+)', page.read_text()):
            if not target.startswith(('http', 'mailto')):
                assert (page.parent / target).exists(), f'{page.name}: {target}'


def test_only_rooms_that_exist_are_named_in_the_readme():
    readme = (ROOT / 'README.md').read_text()
    for folder in re.findall(r'`([a-z_]+)/`', readme):
        exists = (ROOT / folder).is_dir() or list(ROOT.glob(f'*/{folder}'))
        assert exists or folder == 'ama_demo', folder


def test_every_fault_has_a_test_that_exists():
    rows = [
        line
        for line in (ROOT / 'docs' / 'reference' / 'faults.md').read_text().splitlines()
        if line.startswith('|') and not line.startswith(('| fault', '|---'))
    ]
    for row in rows:
        named = re.findall(r'`(test/[^`:]+)::(\w+)`', row)
        assert named, f'no test named in: {row}'
        for file, test in named:
            assert f'def {test}(' in (ROOT / file).read_text(), f'{file}::{test}'


GAP_PAGE = ROOT / 'docs' / 'tutorial' / 'first_gap.md'


@pytest.mark.parametrize(
    'line',
    [line.strip() for line in GAP_PAGE.read_text().splitlines() if line.startswith('    ama ')],
)
def test_commands_of_the_first_gap_have_these_options(line):
    """Unknown commands and options are refused before any help is shown."""
    from typer.testing import CliRunner

    from autonomous_modal_analysis.cli import app

    run = CliRunner().invoke(app, [*shlex.split(line)[1:], '--help'])
    assert run.exit_code == 0, run.output
    wrong = CliRunner().invoke(app, [*shlex.split(line)[1:], '--no-such-option', '--help'])
    assert wrong.exit_code == 2


def test_arm_of_the_first_gap_is_one_the_emulator_takes():
    import yaml

    from abb_emulator.run_plan import ArmOptions

    text = GAP_PAGE.read_text()
    block = text.split('```yaml\n')[1].split('```')[0]
    (effect,) = ArmOptions.from_mapping(yaml.safe_load(block)).cell.effects
    assert (effect.type, effect.place) == ('joint_stiffness', 'joint_2')
