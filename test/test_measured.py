"""Measured figures in the documentation are what programs wrote, and none is stale."""

import json
from pathlib import Path
import re
import sys

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / 'docs')]

from generated_pages.measured import markdown  # noqa: E402

from benchmarks.results import (  # noqa: E402
    definition,
    fingerprint,
    FOLDER,
    Group,
    GROUPS,
    write_lines,
    write_picture,
)
from benchmarks.table import Line  # noqa: E402

DOCS = ROOT / 'docs'
PAPER = DOCS / 'explanation' / 'paper.md'
MEASURED = (*sorted((DOCS / 'measured').glob('*.md')), PAPER)
PAGES = (*MEASURED, DOCS / 'reference' / 'robots.md')


def shown() -> list[str]:
    return [
        name for page in PAGES for name in re.findall(r'```{measured} (\w+)', page.read_text())
    ]


def stale(group: Group, results: dict) -> bool:
    """A program or its settings that changed since, or a drawing that it did not make."""
    drawn = 'picture' not in results or results['picture'] == fingerprint(group.picture)
    same = results['definition'] == definition(group) and results['command'] == group.command
    return not (same and drawn)


def versions() -> list[str]:
    """Return the present version and all before it, as the changelog names them."""
    present = re.search(r"version='([^']+)'", (ROOT / 'setup.py').read_text())[1]
    changes = (ROOT / 'CHANGELOG.rst').read_text()
    return [present, *re.findall(r'^(\d\S+) \(\d{4}-\d\d-\d\d\)$', changes, re.M)]


def test_every_file_of_results_is_shown_once_and_no_other():
    kept = DOCS.glob(f'*/{FOLDER.name}/*.json')
    assert sorted(shown()) == sorted(GROUPS) == sorted(path.stem for path in kept)
    for page in PAGES:
        names = re.findall(r'```{measured} (\w+)', page.read_text())
        assert {GROUPS[name].page for name in names} <= {page.parent.name}, page.name


def test_no_table_of_figures_is_kept_by_hand():
    """Tables by hand may say what to do, but hold no number."""
    for page in MEASURED:
        rows = re.findall(r'^\|.*$', page.read_text(), re.M)
        # What the paper found is no figure of ours: its figures and sections are numbered.
        rows = [re.sub(r'(Figs?\.|Table|Sect\.) [\d, -]+|joint 6|P[123]', '', row) for row in rows]
        assert not [row for row in rows if re.search(r'\d', row)], f'{page.name}: use {{measured}}'


def test_prose_of_the_paper_states_settings_and_no_results():
    """What was measured stands in tables, which programs write: text would go stale."""
    prose = re.sub(r'```.*?```|`[^`]*`|doi:\S+', '', PAPER.read_text(), flags=re.S)
    figures = re.findall(r'[\d.]*\d ?(?:%|Hz|dB|σ|m/s)|\d+\.\d+(?!-\d)', prose)
    settings = {'512 Hz', '60 Hz', '1.9', '7.5', '0.02', '0.01 m/s'}
    assert set(figures) <= settings, 'a setting is listed here; a result comes from a program'


@pytest.mark.parametrize('name', GROUPS)
def test_no_figure_is_stale(name):
    """A change of what is measured asks for measuring again; a new version alone does not.

    What a figure was measured with, and when, stands beside it on its page.
    """
    group = GROUPS[name]
    results = json.loads(group.path.read_text())
    advice = f'{name}.json is stale: run {group.command}, and commit what it wrote'
    assert not stale(group, results), advice
    assert results['version'] in versions(), f'{name}.json: no version of the changelog'
    assert re.fullmatch(r'\d{4}-\d\d-\d\d(?: and \d{4}-\d\d-\d\d)?', results['date']), name
    shown = markdown(results)
    assert results['date'] in shown and f'version {results["version"]}' in shown
    assert all(len(row) == len(results['columns']) for row in results['rows'])
    table = markdown(results).count('\n')
    assert table == (len(results['rows']) + 4 if results['columns'] else 1)


def test_a_changed_program_makes_its_figures_stale(tmp_path, monkeypatch):
    """Thresholds and seeds count; imports and comments, which a move changes, do not."""
    import benchmarks.results as module

    monkeypatch.setattr(module, 'ROOT', tmp_path)
    monkeypatch.setattr(module, 'FOLDER', tmp_path / 'results')
    monkeypatch.setitem(module.GROUPS, 'tracking', Group('tracking', ('b.py',), 'make bench'))
    program = tmp_path / 'b.py'
    program.write_text('import old\n\nREACH = 0.99\n')
    write_lines('tracking', [Line('right ids', '1 | 2', reach='≥ 99 %', met=False)])
    results = json.loads((tmp_path / 'results' / 'tracking.json').read_text())
    group = module.GROUPS['tracking']
    assert not stale(group, results)
    assert '| right ids | 1 \\| 2 | - | - | ≥ 99 % | short |' in markdown(results)
    program.write_text('"""Says more."""\n\nimport new  # elsewhere\n\nREACH = 0.99\n')
    assert not stale(group, results)
    program.write_text('import new\n\nREACH = 0.9\n')
    assert stale(group, results)


def test_other_settings_make_figures_stale(tmp_path, monkeypatch):
    import benchmarks.results as module

    monkeypatch.setattr(module, 'ROOT', tmp_path)
    monkeypatch.setattr(module, 'FOLDER', tmp_path / 'results')
    monkeypatch.setitem(module.GROUPS, 'tracking', Group('tracking', ('b.py',), 'bench --seeds 8'))
    (tmp_path / 'b.py').write_text('REACH = 0.99\n')
    write_lines('tracking', [Line('right ids', '1', reach='2', met=False)])
    results = json.loads((tmp_path / 'results' / 'tracking.json').read_text())
    assert not stale(module.GROUPS['tracking'], results)
    assert stale(Group('tracking', ('b.py',), 'bench --seeds 80'), results)


def test_versions_are_those_of_the_changelog_newest_first():
    present, *named = versions()
    assert len(named) == len(set(named))
    assert named == sorted(named, key=lambda text: [*map(int, text.split('.'))], reverse=True)
    assert present == named[0]


def test_a_picture_that_no_program_drew_is_stale(tmp_path, monkeypatch):
    import benchmarks.results as module

    monkeypatch.setattr(module, 'ROOT', tmp_path)
    monkeypatch.setitem(module.GROUPS, 'drawn', Group('drawn', ('b.py',), 'make', 'explanation'))
    (tmp_path / 'b.py').write_text('REACH = 0.99\n')
    drawing = write_picture('drawn', '<svg/>', ['what it shows'])
    group = module.GROUPS['drawn']
    results = json.loads(group.path.read_text())
    assert not stale(group, results)
    assert 'what it shows' in markdown(results)
    drawing.write_text('<svg><!-- by hand --></svg>')
    assert stale(group, results)
