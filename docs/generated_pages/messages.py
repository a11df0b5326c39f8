"""The reference of messages and services, out of the comments of their definitions."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
import re

from generated_pages.place import cell, ROOT

DEFINITIONS = ROOT / 'oma_msgs'


@dataclass
class Part:
    """A message, or one half of a service: rows of type, name and comment."""

    title: str = ''
    fields: list[list[str]] = field(default_factory=list)
    constants: list[list[str]] = field(default_factory=list)


def read_definition(path: Path) -> tuple[str, list[Part]]:
    """Return what is said at the top, and the parts: one of a message, two of a service."""
    head: list[str] = []
    parts = [Part()] if path.suffix == '.msg' else [Part('Request'), Part('Response')]
    part, last = parts[0], None
    for line in path.read_text().splitlines():
        statement, _, comment = line.partition('#')
        if line.strip() == '---':
            part, last = parts[1], None
        elif statement.strip():
            last = _row(statement.strip(), comment.strip())
            (part.constants if len(last) == 4 else part.fields).append(last)
        elif not line.strip():
            last = None
        elif last is None and not (part.fields or part.constants):
            head.append(comment.strip())
        elif last is not None:
            last[-1] += f' {comment.strip()}'
    return ' '.join(head), parts


def _row(statement: str, comment: str) -> list[str]:
    constant = re.fullmatch(r'(\S+)\s+(\w+)\s*=\s*(.+)', statement)
    if constant:
        return [*constant.groups(), comment]
    kind, name = statement.split(maxsplit=1)
    return [kind, name, comment]


def messages_page() -> str:
    """Return the page of all definitions, as Markdown without a title."""
    return '\n'.join(_lines())


def _lines() -> Iterator[str]:
    for folder, title in (('msg', 'Messages'), ('srv', 'Services')):
        yield f'## {title}\n'
        for path in sorted((DEFINITIONS / folder).glob(f'*.{folder}')):
            head, parts = read_definition(path)
            yield f'(oma-msgs-{path.stem.lower()})=\n### oma_msgs/{path.stem}\n\n{head}\n'
            for part in parts:
                yield from _part_lines(part)


def _part_lines(part: Part) -> Iterator[str]:
    if part.title:
        yield f'**{part.title}**\n'
    if part.fields:
        yield '| field | type | meaning |\n|---|---|---|'
        for kind, name, comment in part.fields:
            yield f'| `{name}` | {_linked(kind)} | {cell(comment)} |'
        yield ''
    if part.constants:
        yield '| constant | value | meaning |\n|---|---|---|'
        for kind, name, value, comment in part.constants:
            yield f'| `{name}` | {value} ({kind}) | {cell(comment)} |'
        yield ''


def _linked(kind: str) -> str:
    base = kind.split('[')[0].split('<')[0]
    name = base.split('/')[-1]
    if (DEFINITIONS / 'msg' / f'{name}.msg').exists():
        return f'[`{kind}`](#oma-msgs-{name.lower()})'
    return f'`{kind}`'
