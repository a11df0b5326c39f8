"""A place among the tokens of a RAPID module, and what may stand there."""

from abb_emulator.rapid.rapid_tokens import refuse, Token

DEEPEST = 20


class TokenCursor:
    """Goes through the tokens; refuses what is not expected by its line.

    Parameters
    ----------
    tokens : list of Token
        Of a module, the end included.
    """

    def __init__(self, tokens: list[Token]) -> None:
        self._tokens, self._place, self._depth = tokens, 0, 0

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
