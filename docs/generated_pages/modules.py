"""One page for each folder of code: what it is for, its modules and what is in them."""

import ast
from collections.abc import Iterator
from pathlib import Path

from generated_pages.place import first_sentence, packages, rooms, ROOT

# What a process starts with; to import it is to run it.
NOT_IMPORTED = ('__main__.py',)


def module_pages() -> dict[str, str]:
    """Return the pages by file name, reStructuredText; ``index.rst`` lists the rooms."""
    pages = {'index.rst': _index()}
    for room in rooms():
        folders = packages(room)
        for folder in folders:
            children = [other for other in folders if other.parent == folder]
            pages[f'{_dotted(folder)}.rst'] = '\n'.join(_page(folder, children))
    return pages


def _dotted(folder: Path) -> str:
    return '.'.join(folder.parts)


def _title(text: str, line: str) -> list[str]:
    return [text, line * len(text), '']


def _index() -> str:
    entries = [f'   {room}' for room in rooms()]
    return '\n'.join([*_title('Rooms and modules', '='), '.. toctree::', '', *entries, ''])


def _page(folder: Path, children: list[Path]) -> Iterator[str]:
    name = _dotted(folder)
    yield from _title(name, '=')
    if (ROOT / folder / '__init__.py').exists():
        yield from (f'.. automodule:: {name}', '   :no-members:', '')
    if children:
        yield from ('.. toctree::', '   :maxdepth: 1', '')
        yield from (f'   {child.name} <{_dotted(child)}>' for child in children)
        yield ''
    modules = _modules(folder)
    if modules:
        yield from _summary(modules)
    for path in modules:
        yield from _title(path.stem, '-')
        yield from (f'.. automodule:: {name}.{path.stem}', '   :members:', '')


def _modules(folder: Path) -> list[Path]:
    return [
        path
        for path in sorted((ROOT / folder).glob('*.py'))
        if path.name != '__init__.py' and path.name not in NOT_IMPORTED
    ]


def _summary(modules: list[Path]) -> Iterator[str]:
    yield from ('.. list-table::', '   :widths: 30 70', '')
    for path in modules:
        dotted = '.'.join(path.relative_to(ROOT).with_suffix('').parts)
        said = first_sentence(ast.get_docstring(ast.parse(path.read_text()))) or path.stem
        yield f'   * - :py:mod:`~{dotted}`'
        yield f'     - {said}'
    yield ''
