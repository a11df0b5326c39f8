"""The directive ``measured``: a table of results as the program that measured them wrote it."""

import json
from pathlib import Path
from typing import Any

from sphinx.util.docutils import SphinxDirective

from generated_pages.place import cell

FOLDER = 'results'


class Measured(SphinxDirective):
    """Show a file of results that lies in ``results`` beside the page; the argument names it."""

    required_arguments = 1
    has_content = False

    def run(self) -> list[Any]:
        """Return the line that says what was measured when, and the table."""
        page = Path(self.env.doc2path(self.env.docname))
        path = page.parent / FOLDER / f'{self.arguments[0]}.json'
        self.env.note_dependency(str(path))
        if not path.exists():
            raise self.error(f'{path.name}: no results of that name in {path.parent}')
        return self.parse_text_to_nodes(markdown(json.loads(path.read_text())))


def markdown(results: dict[str, Any]) -> str:
    """Return results as Markdown."""
    lines = [_provenance(results), '']
    lines.append(f'| {" | ".join(cell(name) for name in results["columns"])} |')
    lines.append(f'|{"---|" * len(results["columns"])}')
    lines += [f'| {" | ".join(cell(item) for item in row)} |' for row in results['rows']]
    return '\n'.join([*lines, ''])


def _provenance(results: dict[str, Any]) -> str:
    where = f', {results["machine"]}' if results.get('machine') else ''
    return (
        f'*Measured by `{results["command"]}` on {results["date"]}, '
        f'version {results["version"]}{where}.*'
    )
