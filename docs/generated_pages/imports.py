"""Which part of the code imports which, read from the source alone."""

import ast
from collections.abc import Iterator
from pathlib import Path

from generated_pages.place import rooms, ROOT

Arrows = dict[str, set[str]]
"""Every part, and the parts it imports."""


def arrows_between_rooms() -> Arrows:
    """Return the rooms and what each imports of the others."""
    names = rooms()
    return _arrows({name: [name] for name in names})


def arrows_within(room: str) -> Arrows:
    """Return the folders of a room, and its own files taken as one part each."""
    parts: dict[str, list[str]] = {}
    for path in sorted((ROOT / room).iterdir()):
        if path.is_dir() and list(path.glob('*.py')):
            parts[f'{room}.{path.name}'] = [f'{room}.{path.name}']
        elif path.suffix == '.py' and path.stem not in ('__init__', '__main__'):
            parts[f'{room}.{path.stem}'] = [f'{room}.{path.stem}']
    return _arrows(parts)


def _arrows(parts: dict[str, list[str]]) -> Arrows:
    found: Arrows = {}
    for name in parts:
        others = {_part_of(imported, parts) for imported in imports_of(name)}
        found[name] = {other for other in others if other and other != name}
    return found


def _part_of(module: str, parts: dict[str, list[str]]) -> str | None:
    for name in parts:
        if module == name or module.startswith(f'{name}.'):
            return name
    return None


def imports_of(dotted: str) -> Iterator[str]:
    """Yield the dotted names that a module, or all modules of a folder, import."""
    place = ROOT.joinpath(*dotted.split('.'))
    files = sorted(place.rglob('*.py')) if place.is_dir() else [place.with_suffix('.py')]
    for path in files:
        yield from _imports(ast.parse(path.read_text()), path)


def _imports(tree: ast.Module, path: Path) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ''
            if node.level:
                here = path.relative_to(ROOT).parent.parts
                base = '.'.join([*here[: len(here) - node.level + 1], *filter(None, [base])])
            yield from (f'{base}.{alias.name}' for alias in node.names)


def without_shortcuts(arrows: Arrows) -> Arrows:
    """Return the arrows that are no shortcut of a longer way; those of a circle stay."""
    kept: Arrows = {}
    for part, direct in arrows.items():
        kept[part] = {
            other
            for other in direct
            if part in _reached(other, arrows)
            or not any(other in _reached(via, arrows) for via in direct - {other})
        }
    return kept


def _reached(part: str, arrows: Arrows) -> set[str]:
    reached: set[str] = set()
    waiting = list(arrows.get(part, ()))
    while waiting:
        other = waiting.pop()
        if other not in reached:
            reached.add(other)
            waiting += arrows.get(other, ())
    return reached


def levels(arrows: Arrows) -> list[list[str]]:
    """Return the parts in rows; what is imported stands below all that import it.

    Parts of a circle share a row.
    """
    depth: dict[str, int] = {}

    def dive(part: str) -> int:
        if part not in depth:
            above = [
                dive(other)
                for other, imported in arrows.items()
                if part in imported and other not in _reached(part, arrows)
            ]
            depth[part] = 1 + max(above, default=-1)
        return depth[part]

    deepest = max((dive(part) for part in arrows), default=-1)
    return [sorted(p for p in arrows if depth[p] == row) for row in range(deepest + 1)]
