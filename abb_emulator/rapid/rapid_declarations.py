"""Declarations of a RAPID module: constants and variables with what they begin as."""

from abb_emulator.rapid.rapid_syntax import (
    Datum,
    IDENT,
    KINDS,
    Literal,
    NUM,
    SPEED_NAMES,
    STRING,
)
from abb_emulator.rapid.rapid_tokens import refuse, Token, tokens_of
from abb_emulator.rapid.rapid_values import ValueParser


class DeclarationParser(ValueParser):
    """Recursive descent through declarations; data are known by name from there on."""

    def __init__(self, tokens: list[Token]) -> None:
        super().__init__(tokens)
        self._data: dict[str, Datum] = {}

    def literal_alone(self) -> Literal:
        """Read one value and nothing behind it."""
        value = self._literal()
        if self._peek().kind != 'end':
            raise refuse('text after a value', 1, self._peek().text)
        return value

    def _declaration(self) -> None:
        storage = self._next()
        kind = self._name()
        if kind.text.lower() not in KINDS:
            raise refuse('unknown type', kind.line, kind.text, ', '.join(KINDS))
        name = self._name()
        if name.text.lower() in self._data:
            raise refuse('declared twice', name.line, name.text)
        rows = self._rows()
        value: Literal | None = None
        if self._accept(':='):
            value = self._initial(kind.text.lower(), rows)
        elif storage.text.lower() == 'const':
            raise refuse('constant without a value', name.line, name.text)
        self._sign(';')
        kind_name = kind.text.lower()
        if value is None:
            value = _empty(kind_name, rows)
        self._data[name.text.lower()] = Datum(
            name.line, kind_name, rows, value, storage.text.lower()
        )

    def _rows(self) -> int:
        if not self._accept('{'):
            return 0
        token = self._next()
        rows = int(token.text) if token.kind == 'number' and token.text.isdigit() else 0
        if rows < 1:
            raise refuse('not a number of elements', token.line, token.text)
        self._sign('}')
        return rows

    def _initial(self, kind: str, rows: int) -> Literal:
        token = self._peek()
        if token.kind == 'name':
            self._next()
            name = token.text.lower()
            if name in SPEED_NAMES and kind == 'speeddata':
                return SPEED_NAMES[name]
            known = self._data.get(name)
            if known is None or (known.kind, known.rows) != (kind, rows):
                raise refuse(f'not a {kind} declared before', token.line, token.text)
            return known.value
        value = self._literal()
        shape = _shape(kind)
        if not _fits(value, (rows, *shape) if rows else shape, kind):
            wanted = f'{rows} x {kind}' if rows else kind
            raise refuse('wrong value', token.line, expected=wanted)
        return value


def value_from(text: str, datum: Datum) -> Literal:
    """Return a value out of its text, of a datum's type.

    Raises
    ------
    BridgeError
        It is of another type.
    """
    parser = DeclarationParser(tokens_of(text))
    value = parser.literal_alone()
    shape = _shape(datum.kind)
    if not _fits(value, (datum.rows, *shape) if datum.rows else shape, datum.kind):
        raise refuse('wrong value', 1, text[:40], datum.kind)
    return value


def _shape(kind: str) -> tuple[int, ...]:
    return {
        'num': (), 'string': (), 'egmident': (), 'robjoint': (6,), 'jointtarget': (2, 6),
        'speeddata': (4,), 'egm_minmax': (2,),
    }[kind]  # fmt: skip


def _fits(value: Literal, shape: tuple[int, ...], kind: str) -> bool:
    if not shape:
        return kind != IDENT and isinstance(value, str if kind == STRING else float)
    if not isinstance(value, tuple) or len(value) != shape[0]:
        return False
    return all(_fits(item, shape[1:], kind if kind == STRING else NUM) for item in value)


def _empty(kind: str, rows: int) -> Literal:
    def build(shape: tuple[int, ...]) -> Literal:
        if not shape:
            return '' if kind in (STRING, IDENT) else 0.0
        return tuple(build(shape[1:]) for _ in range(shape[0]))

    return build((rows, *_shape(kind)) if rows else _shape(kind))
