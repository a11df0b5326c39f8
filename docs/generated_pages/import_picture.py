"""The directive ``import-picture``: rooms, or the folders of one room, and what imports what."""

import ast
from html import escape
import textwrap
from typing import ClassVar

from docutils import nodes
from docutils.parsers.rst import Directive, directives

from generated_pages.imports import (
    Arrows,
    arrows_between_rooms,
    arrows_within,
    levels,
    without_shortcuts,
)
from generated_pages.place import first_sentence, ROOT

BOX_WIDTH, GAP, ROW_GAP, MARGIN = 200, 24, 54, 10
LINE_HEIGHT, LETTERS, MOST_IN_A_ROW = 15, 31, 5


class ImportPicture(Directive):
    """Draw the imports; with ``:room:`` those between the folders and files of one room."""

    option_spec: ClassVar = {'room': directives.unchanged}
    has_content = False

    def run(self) -> list[nodes.Node]:
        """Return the picture as inline SVG, which follows the colours of the theme."""
        room = self.options.get('room')
        arrows = arrows_within(room) if room else arrows_between_rooms()
        title = f'What imports what in {room}' if room else 'What imports what'
        html = f'<div class="import-picture">{svg(arrows, title)}</div>'
        return [nodes.raw('', html, format='html')]


def svg(arrows: Arrows, title: str) -> str:
    """Return the picture; every part links to its page of the reference."""
    rows = _ordered([row for level in levels(arrows) for row in _split(level)], arrows)
    words = {part: _words(part) for part in arrows}
    width = 2 * MARGIN + max(len(row) for row in rows) * (BOX_WIDTH + GAP) - GAP
    places, top = {}, MARGIN
    for row in rows:
        height = 34 + LINE_HEIGHT * max(len(words[part]) for part in row)
        left = (width - len(row) * (BOX_WIDTH + GAP) + GAP) / 2
        for number, part in enumerate(row):
            places[part] = (left + number * (BOX_WIDTH + GAP), top, height)
        top += height + ROW_GAP
    drawn = [
        _arrow(places[part], places[other])
        for part, others in without_shortcuts(arrows).items()
        for other in sorted(others)
    ]
    boxes = [_box(part, places[part], words[part]) for part in places]
    return (
        f'<svg viewBox="0 0 {width:.0f} {top - ROW_GAP + MARGIN:.0f}" role="img" '
        f'style="min-width:{0.62 * width:.0f}px;max-width:{width:.0f}px" '
        f'xmlns="http://www.w3.org/2000/svg"><title>{escape(title)}</title>'
        '<defs><marker id="arrow-end" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0,0 L8,4 L0,8 z"/></marker></defs>'
        f'{"".join(drawn)}{"".join(boxes)}</svg>'
    )


def _split(row: list[str]) -> list[list[str]]:
    """Return a long row as several of about equal length."""
    n_rows = -(-len(row) // MOST_IN_A_ROW)
    size = -(-len(row) // n_rows)
    return [row[start : start + size] for start in range(0, len(row), size)]


def _ordered(rows: list[list[str]], arrows: Arrows) -> list[list[str]]:
    """Sort every row by where its importers stand, so that few arrows cross."""
    place: dict[str, float] = {}
    for row in rows:
        above = {
            part: [place[other] for other in place if part in arrows[other]] for part in row
        }
        row.sort(key=lambda part: sum(above[part]) / len(above[part]) if above[part] else 0.5)
        place.update({part: (n + 0.5) / len(row) for n, part in enumerate(row)})
    return rows


def _words(part: str) -> list[str]:
    place = ROOT.joinpath(*part.split('.'))
    path = place / '__init__.py' if place.is_dir() else place.with_suffix('.py')
    text = ast.get_docstring(ast.parse(path.read_text())) if path.exists() else ''
    return textwrap.wrap(first_sentence(text), LETTERS, max_lines=3, placeholder=' …')


def _box(part: str, place: tuple[float, float, float], words: list[str]) -> str:
    left, top, height = place
    folder = ROOT.joinpath(*part.split('.')).is_dir()
    page = part if folder else part.rsplit('.', 1)[0]
    target = f'../reference/generated/modules/{page}.html'
    lines = ''.join(
        f'<text x="{left + 10:.0f}" y="{top + 38 + LINE_HEIGHT * number:.0f}">{escape(line)}</text>'
        for number, line in enumerate(words)
    )
    name = part.rsplit('.', 1)[-1]
    return (
        f'<a href="{target}" class="{"folder" if folder else "file"}">'
        f'<rect x="{left:.0f}" y="{top:.0f}" width="{BOX_WIDTH}" height="{height:.0f}" rx="6"/>'
        f'<text class="name" x="{left + 10:.0f}" y="{top + 20:.0f}">{escape(name)}</text>{lines}</a>'
    )


def _arrow(start: tuple[float, float, float], end: tuple[float, float, float]) -> str:
    x0, y0 = start[0] + BOX_WIDTH / 2, start[1] + start[2]
    x1, y1 = end[0] + BOX_WIDTH / 2, end[1] - 3
    if y1 <= y0:  # a circle, or a row that was split: round the side
        x0, y0 = start[0] + BOX_WIDTH, start[1] + start[2] / 2
        x1, y1 = end[0] + BOX_WIDTH + 3, end[1] + end[2] / 2
        return f'<path class="arrow" d="M{x0:.0f},{y0:.0f} H{x1 + 9:.0f} V{y1:.0f} H{x1:.0f}"/>'
    bend = ROW_GAP * 0.7
    return (
        f'<path class="arrow" d="M{x0:.0f},{y0:.0f} C{x0:.0f},{y0 + bend:.0f} '
        f'{x1:.0f},{y1 - bend:.0f} {x1:.0f},{y1:.0f}"/>'
    )
