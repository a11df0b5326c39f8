"""The documents of the repository, and the blocks of code in them."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
import re

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / 'docs'
MADE = ('_build', 'generated', 'generated_pages')


def pages() -> list[Path]:
    found = [path for path in DOCS.rglob('*.md') if not set(path.parts) & set(MADE)]
    return [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted(found)]


@dataclass(frozen=True)
class Block:
    """A block of code; ``language`` is empty for one that is only indented."""

    page: str
    line: int
    language: str
    text: str

    def __str__(self) -> str:
        return f'{self.page}:{self.line}'


def blocks(path: Path) -> Iterator[Block]:
    name = str(path.relative_to(ROOT))
    text = path.read_text()
    for found in re.finditer(r'^( *)```(\S*)[^\n]*\n(.*?)^ *```', text, re.M | re.S):
        indent, language, body = found.groups()
        body = ''.join(line.removeprefix(indent) for line in body.splitlines(keepends=True))
        yield Block(name, text[: found.start()].count('\n') + 1, language, body)
    bare = re.sub(
        r'^( *)```.*?^ *```', lambda m: '\n' * m.group().count('\n'), text, flags=re.M | re.S
    )
    for number, line in enumerate(bare.splitlines(), start=1):
        if line.startswith('    '):
            yield Block(name, number, '', line.strip() + '\n')


def _blank_lines(found: re.Match[str]) -> str:
    return '\n' * found.group().count('\n')


def blocks_of(*languages: str) -> list[Block]:
    return [block for path in pages() for block in blocks(path) if block.language in languages]


def anchors(path: Path) -> set[str]:
    """Return the anchors of the headings, as MyST and GitHub make them."""
    text = re.sub(r'^```.*?^```', '', path.read_text(), flags=re.M | re.S)
    titles = re.findall(r'^#+ (.+)$', text, re.M)
    named = re.findall(r'^\((\S+)\)=$', text, re.M)
    return {_slug(title) for title in titles} | set(named)


def _slug(title: str) -> str:
    return re.sub(r'[^\w\- ]', '', title.lower().strip()).replace(' ', '-')
