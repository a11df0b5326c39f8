"""Where the datasets of a universal file begin and end; one that is cut off is refused.

A library that looks for lines of -1 passes a truncated file over, and may take bytes of binary
data for such a line.  Here every dataset is followed to its end, binary ones by the lengths that
their first line states.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import IO

from modal_core.errors import RecordingError

DELIMITER = b'-1'
LONGEST_LINE = 1 << 16


@dataclass(frozen=True, slots=True)
class Block:
    """A dataset.

    Parameters
    ----------
    number : int
        From 1.
    kind : int
        Its type, such as 58.
    """

    number: int
    kind: int


def blocks_of(path: Path) -> list[Block]:
    """Follow the datasets of a file from the first to the last.

    Raises
    ------
    RecordingError
        It is no universal file, or a dataset does not end.
    """
    found: list[Block] = []
    with path.open('rb') as file:
        while _skip_to_start(file, path, bool(found)):
            number = len(found) + 1
            line = file.readline(LONGEST_LINE)
            try:
                kind = int(line[:6])
            except ValueError as error:
                what = 'not a universal file' if not found else f'dataset {number} has no type'
                expected = 'datasets between lines of -1'
                raise RecordingError(what, where=path, expected=expected) from error
            ended = _skip_binary(file, line) if line[6:7] in b'bB' and line[6:7] else True
            if not ended or not _skip_to_end(file):
                raise RecordingError(
                    'truncated universal file',
                    where=path,
                    found=f'dataset {number} of type {kind} begins',
                    expected='a line of -1 where it ends',
                )
            found.append(Block(number, kind))
    if not found:
        raise RecordingError(
            'not a universal file', where=path, expected='datasets between lines of -1'
        )
    return found


def _skip_to_start(file: IO[bytes], path: Path, any_before: bool) -> bool:
    """Go to the line behind the next delimiter; blank lines may stand before it."""
    for line in iter(lambda: file.readline(LONGEST_LINE), b''):
        if line.strip() == DELIMITER:
            return True
        if line.strip():
            what = 'something between its datasets' if any_before else 'not a universal file'
            raise RecordingError(what, where=path, expected='datasets between lines of -1')
    return False


def _skip_binary(file: IO[bytes], first: bytes) -> bool:
    """Go behind the binary data; False where the file ends before them."""
    try:
        n_lines, n_bytes = int(first[19:31]), int(first[31:43])
    except ValueError:
        return False
    for _ in range(n_lines):
        if not file.readline(LONGEST_LINE):
            return False
    place = file.tell() + n_bytes
    return n_bytes >= 0 and place <= file.seek(0, 2) and file.seek(place) == place


def _skip_to_end(file: IO[bytes]) -> bool:
    return any(
        line.strip() == DELIMITER for line in iter(lambda: file.readline(LONGEST_LINE), b'')
    )
