"""The notebooks of the documentation run, and give what they show."""

import ast
import json
from pathlib import Path
import re

import pytest

FOLDER = Path(__file__).resolve().parents[2] / 'docs' / 'tutorial' / 'notebooks'
NOTEBOOKS = [
    pytest.param(path, marks=pytest.mark.slow if path.stem == 'a_robot' else ())
    for path in sorted(FOLDER.glob('*.ipynb'))
]
NUMBER = re.compile(r'-?\d+\.?\d*')
# Of another machine's libraries; plans are made with theirs too.
HASH = re.compile(r'hash \w+')
RELATIVE, ABSOLUTE = 0.03, 0.15


def code_cells(path: Path) -> list[dict]:
    cells = json.loads(path.read_text())['cells']
    return [cell for cell in cells if cell['cell_type'] == 'code']


def shown(cell: dict) -> str:
    """Return what a cell has printed and its value; pictures are left out."""
    texts = []
    for output in cell['outputs']:
        assert output['output_type'] != 'error', output
        if output['output_type'] == 'stream':
            texts.append(''.join(output['text']))
        elif 'image/png' not in output['data']:
            texts.append(''.join(output['data']['text/plain']))
    return ''.join(texts)


def run_cell(source: str, names: dict) -> object:
    """Run a cell; return the value of its last expression, None behind a semicolon."""
    body = ast.parse(source).body
    last = body.pop() if isinstance(body[-1], ast.Expr) else None
    exec(compile(ast.Module(body, []), '<cell>', 'exec'), names)
    if last is None:
        return None
    value = eval(compile(ast.Expression(last.value), '<cell>', 'eval'), names)
    return None if source.rstrip().endswith(';') else value


def same(now: str, then: str) -> bool:
    now, then = HASH.sub('', now), HASH.sub('', then)
    if NUMBER.sub('#', now).split() != NUMBER.sub('#', then).split():
        return False
    numbers = [[float(n) for n in NUMBER.findall(text)] for text in (now, then)]
    return numbers[0] == pytest.approx(numbers[1], rel=RELATIVE, abs=ABSOLUTE)


def test_there_are_two():
    assert len(NOTEBOOKS) >= 2


@pytest.mark.usefixtures('no_window')
@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_gives_what_it_shows(path, tmp_path, monkeypatch, capsys):
    pytest.importorskip('pandas')
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {'__name__': '__main__'}
    for cell in code_cells(path):
        assert cell['execution_count'], 'kept without what it gave'
        source = ''.join(cell['source'])
        value = run_cell(source, names)
        now = capsys.readouterr().out + ('' if value is None else in_notebook(value))
        assert same(now, shown(cell)), f'{source}\ngave now:\n{now}\nkept:\n{shown(cell)}'


def in_notebook(value: object) -> str:
    """Return a value as a notebook writes it: lists of many texts one to a line."""
    if isinstance(value, list):
        return '[' + ',\n '.join(map(repr, value)) + ']'
    return repr(value)


@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_every_picture_is_there(path):
    for cell in code_cells(path):
        if '.plot_' in ''.join(cell['source']):
            kinds = [kind for output in cell['outputs'] for kind in output['data']]
            assert kinds.count('image/png') == 1, cell['source']
