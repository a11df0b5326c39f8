"""The file of a history: an SQLite database that says in one line what is wrong with it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
import sqlite3
from types import TracebackType
from typing import Self

from modal_core.errors import HistoryError
from modal_history.schema import APPLICATION_ID, PAGE_BYTES, SCALARS, STEPS, VERSION

LONGEST_WAIT_S = 30.0
"""How long another program may hold the file."""
REASONS = {
    'SQLITE_FULL': ('disk full', 'make room'),
    'SQLITE_READONLY': ('cannot be written', 'allow writing to the file and its folder'),
    'SQLITE_CANTOPEN': ('cannot be opened', 'its folder must exist and allow writing'),
    'SQLITE_PERM': ('cannot be opened', 'allow reading and writing'),
    'SQLITE_BUSY': (f'another program has held it for {LONGEST_WAIT_S:g} s', 'try again later'),
    'SQLITE_LOCKED': (f'another program has held it for {LONGEST_WAIT_S:g} s', 'try again later'),
    'SQLITE_NOTADB': ('no history of modes', 'name another file'),
    'SQLITE_CORRUPT': (
        'damaged',
        'nothing was changed: put a copy in its place, or save what is left with'
        ' `sqlite3 FILE .recover`',
    ),
    'SQLITE_IOERR': ('cannot be read or written', 'check the disk and its space'),
}
DAMAGED = REASONS['SQLITE_CORRUPT']


class HistoryFile:
    """An open history.

    Parameters
    ----------
    path : path
        The file; made when it is missing and ``write`` is set.
    write : bool
        Whether results are to be added.

    Raises
    ------
    HistoryError
        It is missing, damaged, of a newer version, no history, or cannot be written.
    """

    def __init__(self, path: str | Path, write: bool = False) -> None:
        self.path = path = Path(path)
        if not write and not path.is_file():
            raise HistoryError('no such history', where=path)
        with self.told():
            self.rows = _connect(path, write)
            try:
                self._prepare(write)
            except BaseException:
                self.rows.close()
                raise

    def close(self) -> None:
        """Close the file."""
        self.rows.close()

    @contextmanager
    def told(self) -> Iterator[None]:
        """Turn what SQLite raises into one line."""
        try:
            yield
        except sqlite3.Error as error:
            raise _words(self.path, error) from error

    @contextmanager
    def change(self) -> Iterator[None]:
        """Write all that the block writes, or nothing.

        Raises
        ------
        HistoryError
            It cannot be written; the file is as it was.
        """
        with self.told():
            self.rows.execute('BEGIN IMMEDIATE')
            try:
                yield
                self.rows.execute('COMMIT')
            except BaseException:
                if self.rows.in_transaction:
                    self.rows.execute('ROLLBACK')
                raise

    def damaged(self, found: object) -> HistoryError:
        """Return the error that tells of rows which no program of the suite has written."""
        return HistoryError(DAMAGED[0], where=self.path, found=found, advice=DAMAGED[1])

    def check(self) -> None:
        """Read the whole file.

        Raises
        ------
        HistoryError
            It is damaged.
        """
        with self.told():
            found = [row[0] for row in self.rows.execute('PRAGMA quick_check(1)')]
        if found != ['ok']:
            raise self.damaged(found[0])

    def _prepare(self, write: bool) -> None:
        if write:
            # A commit is on the disk, whatever happens next.
            self.rows.execute('PRAGMA synchronous = EXTRA')
            self.rows.execute(f'PRAGMA page_size = {PAGE_BYTES}')
            with self.change():
                if self._number('user_version') == 0 and not self._tables():
                    self.rows.execute(f'PRAGMA application_id = {APPLICATION_ID}')
                self._check_version()
                self._bring_up_to_date()
                # Also tells at once whether it may be written to.
                self.rows.execute(f'PRAGMA user_version = {VERSION}')
        else:
            self._check_version()

    def _check_version(self) -> None:
        version = self._number('user_version')
        if self._number('application_id') != APPLICATION_ID:
            raise HistoryError('no history of modes', where=self.path, advice='name another file')
        if version > VERSION:
            raise HistoryError(
                'written by a newer version of this software',
                where=self.path,
                found=f'format {version}',
                expected=f'up to {VERSION}',
                advice='nothing was changed: install the newer version',
            )

    def _bring_up_to_date(self) -> None:
        """Give an older file what newer ones have: tables, and all quantities of a mode."""
        for version in range(self._number('user_version') + 1, VERSION + 1):
            for statement in STEPS[version].split(';'):
                self.rows.execute(statement)
        for item in SCALARS:
            if item.name not in self.columns('mode'):
                self.rows.execute(f'ALTER TABLE mode ADD COLUMN {item.name} REAL')

    def columns(self, table: str) -> tuple[str, ...]:
        """Return the names of a table's columns."""
        return tuple(row[1] for row in self.rows.execute(f'PRAGMA table_info({table})'))

    def _number(self, pragma: str) -> int:
        return int(self.rows.execute(f'PRAGMA {pragma}').fetchone()[0])

    def _tables(self) -> int:
        return int(self.rows.execute('SELECT count(*) FROM sqlite_master').fetchone()[0])


class OpenHistory:
    """Works on the file of a history, which is closed at the end of a ``with`` block."""

    file: HistoryFile

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file."""
        self.file.close()


def _connect(path: Path, write: bool) -> sqlite3.Connection:
    # A reader takes back what a program that was killed left half written, so it may write too.
    place = f'{path.absolute().as_uri()}?mode={"rwc" if write else "rw"}'
    rows = sqlite3.connect(
        place, uri=True, timeout=LONGEST_WAIT_S, isolation_level=None, check_same_thread=False
    )
    # A file from anywhere brings no code of its own.
    rows.execute('PRAGMA trusted_schema = OFF')
    if not write:
        rows.execute('PRAGMA query_only = ON')
    return rows


def _words(path: Path, error: sqlite3.Error) -> HistoryError:
    name = getattr(error, 'sqlite_errorname', '')
    for code, (what, advice) in REASONS.items():
        if name.startswith(code):
            return HistoryError(what, where=path, found=error, advice=advice)
    return HistoryError(DAMAGED[0], where=path, found=error, advice=DAMAGED[1])
