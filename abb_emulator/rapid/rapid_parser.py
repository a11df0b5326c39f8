"""Reads a RAPID module: the subset exported programs use, everything else refused by its line."""

from collections.abc import Callable

from abb_emulator.rapid.rapid_check import check_module
from abb_emulator.rapid.rapid_syntax import (
    Assignment,
    Branch,
    Call,
    Constant,
    Datum,
    Function,
    IDENT,
    KINDS,
    Literal,
    Loop,
    Module,
    NUM,
    Operation,
    Procedure,
    Reference,
    SPEED_NAMES,
    Statement,
    STRING,
    Value,
)
from abb_emulator.rapid.rapid_tokens import refuse, Token, tokens_of

STORAGE = ('const', 'var', 'pers')
DEEPEST = 20
ENDINGS = ('endproc', 'endfor', 'endif', 'error')
COMPARISONS = ('<', '<=', '>', '>=', '=', '<>')


def parse_module(text: str) -> Module:
    """Read and check one module.

    Parameters
    ----------
    text : str
        Contents of a .mod file.

    Raises
    ------
    BridgeError
        Anything the emulator does not execute, with its line.
    """
    module = _Parser(tokens_of(text)).module()
    check_module(module)
    return module


class _Parser:
    """Recursive descent over the tokens."""

    def __init__(self, tokens: list[Token]) -> None:
        self._tokens, self._place, self._depth = tokens, 0, 0
        self._data: dict[str, Datum] = {}

    def module(self) -> Module:
        """Read ``MODULE name { data | proc } ENDMODULE``."""
        self._word('module')
        name = self._name().text
        procedures: dict[str, Procedure] = {}
        while not self._at('endmodule'):
            token = self._peek()
            word = token.text.lower()
            if word == 'local':
                self._next()
            elif word in STORAGE:
                self._declaration()
            elif word == 'proc':
                self._procedure(procedures)
            else:
                raise refuse('unknown declaration', token.line, token.text)
        self._next()
        if self._peek().kind != 'end':
            raise refuse('text after ENDMODULE', self._peek().line, self._peek().text)
        if 'main' not in procedures:
            raise refuse('no PROC main', self._peek().line)
        return Module(name, self._data, procedures)

    # -- declarations --------------------------------------------------------------------------

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
        constant = storage.text.lower() == 'const'
        kind_name = kind.text.lower()
        if value is None:
            value = _empty(kind_name, rows)
        self._data[name.text.lower()] = Datum(name.line, kind_name, rows, value, constant)

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

    def _literal(self) -> Literal:
        token = self._next()
        if token.text == '-' and self._peek().kind == 'number':
            return -float(self._next().text)
        if token.kind == 'number':
            return float(token.text)
        if token.kind == 'text':
            return token.text[1:-1].replace('""', '"')
        if token.text != '[':
            raise refuse('not a value', token.line, token.text)
        self._deeper(token)
        items = [self._literal()]
        while self._accept(','):
            items.append(self._literal())
        self._sign(']')
        self._depth -= 1
        return _row(items)

    # -- procedures ----------------------------------------------------------------------------

    def _procedure(self, procedures: dict[str, Procedure]) -> None:
        line = self._next().line
        name = self._name()
        for sign in '()':
            self._sign(sign)
        body = self._statements()
        handler: tuple[Statement, ...] = ()
        if self._accept_word('error'):
            handler = self._statements()
        self._word('endproc')
        if name.text.lower() in procedures:
            raise refuse('procedure declared twice', name.line, name.text)
        procedures[name.text.lower()] = Procedure(line, body, handler)

    def _statements(self) -> tuple[Statement, ...]:
        statements: list[Statement] = []
        while self._peek().text.lower() not in ENDINGS:
            statements.append(self._statement())
        return tuple(statements)

    def _statement(self) -> Statement:
        token = self._name()
        word = token.text.lower()
        if word == 'for':
            return self._loop(token)
        if word == 'if':
            return self._branch(token)
        field = ''
        if self._accept('.'):
            field = self._name().text.lower()
        if self._accept(':='):
            value = self._value()
            self._sign(';')
            return Assignment(token.line, word, field, value)
        if field:
            raise refuse('expected an assignment', token.line, token.text)
        return self._call(token)

    def _loop(self, token: Token) -> Loop:
        self._deeper(token)
        variable = self._name().text.lower()
        self._word('from')
        first = self._value()
        self._word('to')
        last = self._value()
        self._word('do')
        body = self._statements()
        self._word('endfor')
        self._depth -= 1
        return Loop(token.line, variable, first, last, body)

    def _branch(self, token: Token) -> Branch:
        self._deeper(token)
        condition = self._value()
        self._word('then')
        body = self._statements()
        self._word('endif')
        self._depth -= 1
        return Branch(token.line, condition, body)

    def _call(self, token: Token) -> Call:
        arguments: list[Value] = []
        options: dict[str, Value | None] = {}
        while not self._accept(';'):
            if self._accept('\\'):
                option = self._name()
                if option.text.lower() in options:
                    raise refuse('given twice', option.line, option.text)
                options[option.text.lower()] = self._value() if self._accept(':=') else None
                self._accept(',')
                continue
            arguments.append(self._value())
            if self._peek().text not in (',', '\\', ';'):
                found = self._peek()
                raise refuse(f'{token.text}: unexpected', found.line, found.text)
            self._accept(',')
        return Call(token.line, token.text.lower(), tuple(arguments), options)

    # -- values, loosest binding first -----------------------------------------------------------

    def _value(self) -> Value:
        return self._chain(('or',), self._all)

    def _all(self) -> Value:
        return self._chain(('and',), self._comparison)

    def _comparison(self) -> Value:
        return self._chain(COMPARISONS, self._sum)

    def _sum(self) -> Value:
        return self._chain(('+', '-'), self._simple)

    def _chain(self, signs: tuple[str, ...], operand: Callable[[], Value]) -> Value:
        value = operand()
        while self._peek().text.lower() in signs and self._peek().kind in ('sign', 'name'):
            token = self._next()
            value = Operation(token.line, token.text.lower(), value, operand())
        return value

    def _simple(self) -> Value:
        token = self._peek()
        if token.kind != 'name':
            return Constant(self._literal())
        self._next()
        if self._accept('('):
            return self._function(token)
        index = None
        if self._accept('{'):
            self._deeper(token)
            index = self._value()
            self._depth -= 1
            self._sign('}')
        fields: list[str] = []
        while self._accept('.'):
            fields.append(self._name().text.lower())
        return Reference(token.text.lower(), index, tuple(fields))

    def _function(self, token: Token) -> Function:
        self._deeper(token)
        arguments: list[Value] = []
        while not self._accept(')'):
            arguments.append(self._value())
            if self._peek().text != ')':
                self._sign(',')
        self._depth -= 1
        return Function(token.line, token.text.lower(), tuple(arguments))

    # -- tokens --------------------------------------------------------------------------------

    def _peek(self) -> Token:
        return self._tokens[self._place]

    def _next(self) -> Token:
        token = self._tokens[self._place]
        if token.kind == 'end':
            raise refuse('module ends too early', token.line)
        self._place += 1
        return token

    def _at(self, word: str) -> bool:
        return self._peek().text.lower() == word

    def _accept(self, sign: str) -> bool:
        found = self._peek().kind == 'sign' and self._peek().text == sign
        self._place += found
        return found

    def _accept_word(self, word: str) -> bool:
        found = self._at(word)
        self._place += found
        return found

    def _sign(self, sign: str) -> None:
        if not self._accept(sign):
            raise refuse('unexpected', self._peek().line, self._peek().text, sign)

    def _word(self, word: str) -> None:
        if not self._accept_word(word):
            token = self._peek()
            raise refuse('unexpected', token.line, token.text, word.upper())

    def _name(self) -> Token:
        token = self._next()
        if token.kind != 'name':
            raise refuse('unexpected', token.line, token.text, 'a name')
        return token

    def _deeper(self, token: Token) -> None:
        self._depth += 1
        if self._depth > DEEPEST:
            raise refuse('nested too deeply', token.line)


def _row(items: list[Literal]) -> Literal:
    return tuple(items)


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
