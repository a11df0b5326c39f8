"""RAPID text as tokens with their lines."""

from dataclasses import dataclass
import re

from modal_core.errors import BridgeError

LARGEST_CHARACTERS = 8_000_000
LONGEST_NAME = 32
_PATTERN = re.compile(
    r"""(?P<skip>[ \t\r]+|![^\n]*)
    |(?P<end_of_line>\n)
    |(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
    |(?P<text>"(?:[^"\n]|"")*")
    |(?P<name>[A-Za-z][A-Za-z0-9_]*)
    |(?P<sign>:=|<>|<=|>=|[{}\[\](),;.\\<>=+-])""",
    re.VERBOSE,
)


@dataclass(frozen=True, slots=True)
class Token:
    """One word, number, string or sign.

    Parameters
    ----------
    kind : str
        ``number``, ``text``, ``name``, ``sign`` or ``end``.
    text : str
        As written.
    line : int
        Counted from 1.
    """

    kind: str
    text: str
    line: int


def refuse(what: str, line: int, found: object = None, expected: object = None) -> BridgeError:
    """Return the error that names a line of the module."""
    return BridgeError(what, where=f'RAPID line {line}', found=found, expected=expected)


def tokens_of(text: str) -> list[Token]:
    """Return the tokens of a module, the last one of kind ``end``.

    Raises
    ------
    BridgeError
        A character no token begins with, or a module beyond all measure.
    """
    if len(text) > LARGEST_CHARACTERS:
        raise BridgeError('module too large', found=len(text), expected=LARGEST_CHARACTERS)
    found, line, place = [], 1, 1 if text.startswith('\ufeff') else 0
    while place < len(text):
        match = _PATTERN.match(text, place)
        if match is None:
            raise refuse('not RAPID', line, repr(text[place : place + 12]))
        place = match.end()
        kind = str(match.lastgroup)
        if kind == 'end_of_line':
            line += 1
        elif kind != 'skip':
            if kind == 'name' and len(match.group()) > LONGEST_NAME:
                raise refuse('name longer than RAPID allows', line, match.group()[:40], 32)
            found.append(Token(kind, match.group(), line))
    return [*found, Token('end', 'end of file', line)]
