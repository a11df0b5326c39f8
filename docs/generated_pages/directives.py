"""The directives ``import-picture`` and ``measured``."""

import json
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import Directive, directives
from sphinx.util.docutils import SphinxDirective

from generated_pages.imports import arrows_between_rooms, arrows_within
from generated_pages.measured import FOLDER, markdown
from generated_pages.picture import svg


class ImportPicture(Directive):
    """Draw what imports what; with ``:room:`` between the folders and files of one room."""

    option_spec: ClassVar = {'room': directives.unchanged}
    has_content = False

    def run(self) -> list[nodes.Node]:
        """Return the picture as inline SVG, which follows the colours of the theme."""
        room = self.options.get('room')
        arrows = arrows_within(room) if room else arrows_between_rooms()
        title = f'What imports what in {room}' if room else 'What imports what'
        html = f'<div class="import-picture">{svg(arrows, title)}</div>'
        return [nodes.raw('', html, format='html')]


class Measured(SphinxDirective):
    """Show a file of results that lies in ``results`` beside the page; the argument names it.

    A picture is drawn in place, so that its colours follow those of the theme.
    """

    required_arguments = 1
    has_content = False

    def run(self) -> list[Any]:
        """Return the line that says what was measured when, and the table or picture."""
        page = Path(self.env.doc2path(self.env.docname))
        path = page.parent / FOLDER / f'{self.arguments[0]}.json'
        self.env.note_dependency(str(path))
        if not path.exists():
            raise self.error(f'{path.name}: no results of that name in {path.parent}')
        results = json.loads(path.read_text())
        said = self.parse_text_to_nodes(markdown(results))
        if 'picture' not in results:
            return said
        drawing = path.with_suffix('.svg')
        self.env.note_dependency(str(drawing))
        return [
            nodes.raw('', f'<div class="drawn">{drawing.read_text()}</div>', format='html'),
            *said,
        ]
