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
EVEN, VALUE_BYTES = 1, {2: 4, 4: 8, 5: 8, 6: 16}


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
    """Go behind the binary data; False where the file ends before them.

    Their length is stated; of complex values some programs state half of it, so that what the
    number of points and their kind make counts where the dataset ends there.
    """
    try:
        n_lines, n_bytes = int(first[19:31]), int(first[31:43])
    except ValueError:
        return False
    header = [file.readline(LONGEST_LINE) for _ in range(max(0, n_lines))]
    start, size = file.tell(), file.seek(0, 2)
    if not all(header) or n_bytes < 0:
        return False
    announced = _announced_bytes(header)
    places = [start + n for n in (n_bytes, announced) if n is not None and start + n <= size]
    ends = [place for place in places if _ends_at(file, place)]
    place = (ends or [start + n_bytes])[0]
    return place <= size and file.seek(place) == place


def _announced_bytes(header: list[bytes]) -> int | None:
    """Return the length of evenly spaced values by their kind and number, in the seventh line."""
    try:
        kind, n_points, spacing = (int(header[6][first : first + 10]) for first in (0, 10, 20))
    except (ValueError, IndexError):
        return None
    return VALUE_BYTES[kind] * n_points if kind in VALUE_BYTES and spacing == EVEN else None


def _ends_at(file: IO[bytes], place: int) -> bool:
    file.seek(place)
    return file.read(16).lstrip().startswith(DELIMITER)


def _skip_to_end(file: IO[bytes]) -> bool:
    return any(
        line.strip() == DELIMITER for line in iter(lambda: file.readline(LONGEST_LINE), b'')
    )
