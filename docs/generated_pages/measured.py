"""A table or picture of results as the program that measured them wrote it."""

from typing import Any

from generated_pages.place import cell

FOLDER = 'results'


def markdown(results: dict[str, Any]) -> str:
    """Return results as Markdown: what measured them when, and the table where there is one."""
    lines = [_provenance(results), '']
    if not results['columns']:
        return '\n'.join(lines)
    lines.append(f'| {" | ".join(cell(name) for name in results["columns"])} |')
    lines.append(f'|{"---|" * len(results["columns"])}')
    lines += [f'| {" | ".join(cell(item) for item in row)} |' for row in results['rows']]
    return '\n'.join([*lines, ''])


def _provenance(results: dict[str, Any]) -> str:
    parts = (results['date'], f'version {results["version"]}', *results.get('where', ()))
    command = results['command']
    by = (
        'in single runs by hand, which no program repeats'
        if command == 'by hand'
        else f'by `{command}`'
    )
    return f'*Measured {by}: {", ".join(parts)}.*'
