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
# Joints that stick and slide answer the last bit of a motion, which is of a machine's libraries:
# what is measured of them is another draw of the same scatter.
SLIDES = '.emulate('
MEASURED = re.compile(r'(\d+\.?\d*) ± (\d+\.?\d*)')
FARTHEST_STD, LARGEST_RATIO = 4.0, 2.5
# A remark on a mode, which one draw earns and another does not.
REMARK = 'phases scatter'


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


def same(now: str, then: str, *, slides: bool) -> bool:
    now, then = HASH.sub('', now), HASH.sub('', then)
    if slides:
        now, then = now.replace(REMARK, ''), then.replace(REMARK, '')
    if NUMBER.sub('#', now).split() != NUMBER.sub('#', then).split():
        return False
    if slides:
        pairs = zip(MEASURED.findall(now), MEASURED.findall(then), strict=True)
        return all(agree(*map(float, (*first, *second))) for first, second in pairs)
    numbers = [[float(n) for n in NUMBER.findall(text)] for text in (now, then)]
    return numbers[0] == pytest.approx(numbers[1], rel=RELATIVE, abs=ABSOLUTE)


def agree(first: float, first_std: float, second: float, second_std: float) -> bool:
    ratio = max(first_std, second_std) / min(first_std, second_std)
    far = abs(first - second) > FARTHEST_STD * (first_std**2 + second_std**2) ** 0.5
    return ratio <= LARGEST_RATIO and not far


def test_another_draw_agrees_and_another_value_does_not():
    kept = ' 37.94 ± 0.27  2.46 ± 0.57  0.967'
    assert same(' 37.95 ± 0.33  3.32 ± 0.84  0.916', kept, slides=True)
    assert not same(' 37.95 ± 0.33  3.32 ± 0.84  0.916', kept, slides=False)
    assert not same(' 39.94 ± 0.27  2.46 ± 0.57  0.967', kept, slides=True)
    assert not same(' 37.94 ± 0.07  2.46 ± 0.57  0.967', kept, slides=True)
    assert not same(kept + kept, kept, slides=True)


def test_there_are_two():
    assert len(NOTEBOOKS) >= 2


@pytest.mark.usefixtures('no_window')
@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_gives_what_it_shows(path, tmp_path, monkeypatch, capsys):
    pytest.importorskip('pandas')
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {'__name__': '__main__'}
    slides = False
    for cell in code_cells(path):
        assert cell['execution_count'], 'kept without what it gave'
        source = ''.join(cell['source'])
        slides |= SLIDES in source
        value = run_cell(source, names)
        now = capsys.readouterr().out + ('' if value is None else in_notebook(value))
        kept = shown(cell)
        assert same(now, kept, slides=slides), f'{source}\ngave now:\n{now}\nkept:\n{kept}'


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
