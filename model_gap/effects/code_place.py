"""Where in others' code something is: a file as its user calls it, a line, and what is there."""

from dataclasses import dataclass, replace
from pathlib import Path
import traceback


@dataclass(frozen=True)
class CodePlace:
    """A place in a file; as text it is what an error names as its place.

    Parameters
    ----------
    file : str
        File, or the entry point it is loaded from.
    what : str
        Class, method; empty for the file as a whole.
    line : int, optional
        Line in the file, from 1.
    """

    file: str
    what: str = ''
    line: int | None = None

    def __str__(self) -> str:
        """Return ``file:line: what``, without what is not known."""
        file = self.file if self.line is None else f'{self.file}:{self.line}'
        return f'{file}: {self.what}' if self.what else file

    def inside(self, what: str) -> 'CodePlace':
        """Return the place of something that is in what is here."""
        return replace(self, what=': '.join(filter(None, (self.what, what))))

    def of(self, error: BaseException) -> 'CodePlace':
        """Return the same with the last line of the file that an exception went through."""
        lines = [(it.filename, it.lineno) for it in traceback.extract_tb(error.__traceback__)]
        if isinstance(error, SyntaxError) and error.filename:
            lines.append((error.filename, error.lineno))
        # Python makes the path of a file it loads absolute, whatever its user calls it.
        path = Path(self.file).resolve()
        own = [line for file, line in lines if Path(file).resolve() == path]
        return replace(self, line=own[-1]) if own else self
