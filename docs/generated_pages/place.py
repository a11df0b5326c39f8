"""Where the source tree is, and what of it is documented."""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def rooms() -> tuple[str, ...]:
    """Return the top-level packages that are installed, as ``setup.py`` lists them."""
    tree = ast.parse((ROOT / 'setup.py').read_text())
    for node in tree.body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], 'id', '') == 'ROOMS':
            return tuple(sorted(ast.literal_eval(node.value)))
    raise LookupError('setup.py: no list ROOMS')


def packages(room: str) -> list[Path]:
    """Return the room and its folders that hold modules, relative to the root."""
    folders = {path.parent for path in (ROOT / room).rglob('*.py')}
    return sorted(folder.relative_to(ROOT) for folder in folders)


def write_when_changed(path: Path, text: str) -> None:
    """Write a file; one that says the same already keeps its time, so that it is not read anew."""
    if path.exists() and path.read_text() == text:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def first_sentence(text: str | None) -> str:
    """Return the first sentence of a docstring on one line, without its full stop."""
    first = (text or '').strip().split('\n\n')[0]
    line = ' '.join(first.split())
    return line.split('. ')[0].rstrip('.')


def cell(text: object) -> str:
    """Return text that may stand in a cell of a Markdown table."""
    line = ' '.join(str(text).split())
    for letter in '\\|*<':
        line = line.replace(letter, f'\\{letter}')
    return line
