"""The manifest of a batch: a line per recording, written as it is done and never rewritten."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import csv
import fcntl
import io
import json
import os
from pathlib import Path
from typing import BinaryIO

from autonomous_modal_analysis.batch.row import Row
from modal_core.errors import BatchError
from modal_core.files.atomic_file import write_text

NAME, TABLE = 'manifest.jsonl', 'manifest.csv'
LARGEST_BYTES = 500_000_000
"""A row has 380 bytes, more with remarks: a million recordings. What is larger is another file."""


class Manifest:
    """Rows of a batch by recording; the newest of a recording counts.

    Made by :func:`open_manifest`.

    Parameters
    ----------
    file : binary file
        Open for reading and appending, locked.
    path : Path
        Its place.

    Raises
    ------
    BatchError
        It is no manifest.
    """

    def __init__(self, file: BinaryIO, path: Path) -> None:
        self._file, self.path = file, path
        self.rows: dict[str, Row] = {}
        self._read()

    def add(self, row: Row) -> None:
        """Add what became of a recording; it is on the disk when this returns.

        Raises
        ------
        OSError
            It cannot be written.
        """
        self._file.write(json.dumps(row.values(), ensure_ascii=False).encode() + b'\n')
        self._file.flush()
        os.fsync(self._file.fileno())
        self.rows[row.recording] = row

    def write_table(self) -> None:
        """Write the rows as a table for people and other programs."""
        write_text(self.path.with_name(TABLE), csv_text(self.rows))

    def _read(self) -> None:
        if self.path.stat().st_size > LARGEST_BYTES:
            raise BatchError('not the manifest of a batch', where=self.path, found='its size')
        self._file.seek(0)
        whole = 0
        for number, line in enumerate(self._file, 1):
            if not line.endswith(b'\n'):
                break  # What was being written when a batch was killed: it is done again.
            self._take(number, line)
            whole += len(line)
        self._file.truncate(whole)

    def _take(self, number: int, line: bytes) -> None:
        try:
            row = Row.from_values(json.loads(line))
        except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
            raise BatchError(
                'not the manifest of a batch',
                where=self.path,
                found=f'line {number}',
                advice='name another folder with --out',
            ) from error
        self.rows[row.recording] = row


@contextmanager
def open_manifest(folder: Path, resume: bool) -> Iterator[Manifest]:
    """Open the manifest in a folder for this batch alone; make it when missing.

    Parameters
    ----------
    folder : Path
        Of the batch.
    resume : bool
        Go on with what is there; False: there must be nothing.

    Raises
    ------
    BatchError
        Another batch writes there, it holds one already, or the manifest is none.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / NAME
    with path.open('a+b') as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise BatchError('another batch writes there', where=folder) from error
        if path.stat().st_size and not resume:
            raise BatchError(
                'holds a batch already',
                where=folder,
                advice='go on with it: --resume; or name another folder with --out',
            )
        yield Manifest(file, path)


def csv_text(rows: Mapping[str, Row]) -> str:
    """Return rows as CSV, one per recording."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    for number, row in enumerate(rows.values()):
        values = {**row.values(), 'remarks': '; '.join(row.remarks)}
        if not number:
            writer.writerow(values)
        writer.writerow(values.values())
    return text.getvalue()
