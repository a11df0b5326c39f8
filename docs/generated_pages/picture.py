"""A picture of what imports what: rooms, or the folders of one room, as SVG."""

import ast
from html import escape
from itertools import pairwise
from statistics import fmean
import textwrap

from generated_pages.imports import Arrows, levels, without_shortcuts
from generated_pages.place import first_sentence, ROOT

BOX_WIDTH, GAP, ROW_GAP, MARGIN = 240, 22, 46, 10
LINE_HEIGHT, LETTERS = 15, 34
SWEEPS = 6
LANE = ' '
"""Begins the name of a place that keeps room for an arrow to pass a row."""


def svg(arrows: Arrows, title: str) -> str:
    """Return the picture; every part links to its page of the reference."""
    rows, ways = _laid_out(arrows)
    words = {part: _words(part) for part in arrows}
    widths = [sum(_width(part) + GAP for part in row) - GAP for row in rows]
    width = 2 * MARGIN + max(widths)
    places, top = {}, MARGIN
    for row, row_width in zip(rows, widths, strict=True):
        height = 34 + LINE_HEIGHT * max(len(words.get(part, ())) for part in row)
        left = (width - row_width) / 2
        for part in row:
            places[part] = (left, top, height)
            left += _width(part) + GAP
        top += height + ROW_GAP
    drawn = [_arrow([places[part] for part in way], way) for way in ways]
    boxes = [_box(part, places[part], words[part]) for part in arrows]
    return (
        f'<svg viewBox="0 0 {width:.0f} {top - ROW_GAP + MARGIN:.0f}" role="img" '
        f'style="min-width:{0.62 * width:.0f}px;max-width:{width:.0f}px" '
        f'xmlns="http://www.w3.org/2000/svg"><title>{escape(title)}</title>'
        '<defs><marker id="arrow-end" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0,0 L8,4 L0,8 z"/></marker></defs>'
        f'{"".join(drawn)}{"".join(boxes)}</svg>'
    )


def _width(part: str) -> float:
    return 4.0 if part.startswith(LANE) else BOX_WIDTH


def _laid_out(arrows: Arrows) -> tuple[list[list[str]], list[list[str]]]:
    """Return the rows, with lanes for arrows that pass them, and the way of every arrow."""
    rows = levels(arrows)
    row_of = {part: number for number, row in enumerate(rows) for part in row}
    ways = []
    for part, others in sorted(without_shortcuts(arrows).items()):
        for other in sorted(others):
            passed = range(row_of[part] + 1, row_of[other])
            lanes = [f'{LANE}{part} {other} {row}' for row in passed]
            for row, lane in zip(passed, lanes, strict=True):
                rows[row].append(lane)
            ways.append([part, *lanes, other])
    return _ordered(rows, ways), ways


def _ordered(rows: list[list[str]], ways: list[list[str]]) -> list[list[str]]:
    """Sort every row by where its neighbours stand, so that few arrows cross."""
    steps = [step for way in ways for step in pairwise(way)]
    place = {part: (n + 0.5) / len(row) for row in rows for n, part in enumerate(row)}
    for _ in range(SWEEPS):
        for order, here, there in ((rows, 1, 0), (rows[::-1], 0, 1)):
            for row in order:
                near = {part: [place[s[there]] for s in steps if s[here] == part] for part in row}
                row.sort(key=lambda part: fmean(near[part] or [place[part]]))
                place.update({part: (n + 0.5) / len(row) for n, part in enumerate(row)})
    return rows


def _words(part: str) -> list[str]:
    place = ROOT.joinpath(*part.split('.'))
    path = place / '__init__.py' if place.is_dir() else place.with_suffix('.py')
    text = ast.get_docstring(ast.parse(path.read_text())) if path.exists() else ''
    return textwrap.wrap(
        first_sentence(text).replace('`', ''), LETTERS, max_lines=3, placeholder=' …'
    )


def _box(part: str, place: tuple[float, float, float], words: list[str]) -> str:
    left, top, height = place
    folder = ROOT.joinpath(*part.split('.')).is_dir()
    page = part if folder else part.rsplit('.', 1)[0]
    target = f'../reference/generated/modules/{page}.html'
    lines = ''.join(
        _text(left, top + 38 + LINE_HEIGHT * number, line) for number, line in enumerate(words)
    )
    name = part.rsplit('.', 1)[-1]
    return (
        f'<a href="{target}" class="{"folder" if folder else "file"}">'
        f'<rect x="{left:.0f}" y="{top:.0f}" width="{BOX_WIDTH}" height="{height:.0f}" rx="6"/>'
        f'{_text(left, top + 20, name, "name")}{lines}</a>'
    )


def _text(left: float, y: float, line: str, kind: str = 'word') -> str:
    return f'<text class="{kind}" x="{left + 10:.0f}" y="{y:.0f}">{escape(line)}</text>'


def _arrow(places: list[tuple[float, float, float]], way: list[str]) -> str:
    """Return one arrow, from the foot of the first box through its lanes to the last."""
    middles = [left + _width(part) / 2 for part, (left, _, _) in zip(way, places, strict=True)]
    if places[-1][1] <= places[0][1]:  # a circle: round the side
        right = max(places[0][0], places[-1][0]) + BOX_WIDTH
        y0, y1 = (top + height / 2 for _, top, height in (places[0], places[-1]))
        x0, x1 = places[0][0] + BOX_WIDTH, places[-1][0] + BOX_WIDTH + 3
        return f'<path class="arrow" d="M{x0:.0f},{y0:.0f} H{right + 9:.0f} V{y1:.0f} H{x1:.0f}"/>'
    path = f'M{middles[0]:.0f},{places[0][1] + places[0][2]:.0f}'
    for x0, x1, before, after in zip(middles, middles[1:], places, places[1:], strict=False):
        y0, y1 = before[1] + before[2], after[1] - (3 if after is places[-1] else 0)
        half = (y0 + y1) / 2
        path += f' C{x0:.0f},{half:.0f} {x1:.0f},{half:.0f} {x1:.0f},{y1:.0f}'
        if after is not places[-1]:
            path += f' V{after[1] + after[2]:.0f}'
    return f'<path class="arrow" d="{path}"/>'
