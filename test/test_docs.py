"""The documentation names what there is."""

from pathlib import Path
import re

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
    text = (ROOT / 'docs' / 'topics.md').read_text()
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
    for page in [ROOT / 'README.md', *sorted((ROOT / 'docs').glob('*.md'))]:
        for target in re.findall(r'\]\(([^)#]+)', page.read_text()):
            if not target.startswith(('http', 'mailto')):
                assert (page.parent / target).exists(), f'{page.name}: {target}'


def test_only_rooms_that_exist_are_named_in_the_readme():
    readme = (ROOT / 'README.md').read_text()
    for folder in re.findall(r'`([a-z_]+)/`', readme):
        exists = (ROOT / folder).is_dir() or list(ROOT.glob(f'*/{folder}'))
        assert exists or folder == 'ama_demo', folder
