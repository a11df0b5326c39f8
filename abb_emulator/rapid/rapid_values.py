"""Values of a RAPID module: literals, and expressions of what was declared."""

from collections.abc import Callable

from abb_emulator.rapid.rapid_cursor import TokenCursor
from abb_emulator.rapid.rapid_syntax import (
    Constant,
    Function,
    Literal,
    Operation,
    Reference,
    Value,
)
from abb_emulator.rapid.rapid_tokens import refuse, Token

COMPARISONS = ('<', '<=', '>', '>=', '=', '<>')


class ValueParser(TokenCursor):
    """Recursive descent through values."""

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

    # -- expressions, loosest binding first ----------------------------------------------------

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


def _row(items: list[Literal]) -> Literal:
    return tuple(items)
