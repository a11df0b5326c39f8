"""Reads a RAPID module: the subset exported programs use, everything else refused by its line."""

from abb_emulator.rapid.rapid_check import check_module
from abb_emulator.rapid.rapid_declarations import DeclarationParser
from abb_emulator.rapid.rapid_syntax import (
    Assignment,
    Branch,
    Call,
    Loop,
    Module,
    Procedure,
    Statement,
    Value,
)
from abb_emulator.rapid.rapid_tokens import refuse, Token, tokens_of

STORAGE = ('const', 'var', 'pers')
ENDINGS = ('endproc', 'endfor', 'endif', 'error')


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


class _Parser(DeclarationParser):
    """Recursive descent through procedures and their statements."""

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
