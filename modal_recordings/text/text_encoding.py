"""In which encoding a text file is written, from its beginning."""

import codecs
from pathlib import Path

from modal_core.errors import RecordingError

HEAD_BYTES = 1 << 16
MARKS = (
    (codecs.BOM_UTF8, 'utf-8-sig'),
    (codecs.BOM_UTF16_LE, 'utf-16'),
    (codecs.BOM_UTF16_BE, 'utf-16'),
)
LINES = '\t\n\r\f'


def encoding_of(path: Path) -> str:
    """Return the encoding of a text file: UTF-8, UTF-16, or Windows-1252 (° and ² of old loggers).

    Raises
    ------
    RecordingError
        It cannot be read, or is no text.
    """
    try:
        with path.open('rb') as file:
            head = file.read(HEAD_BYTES)
    except OSError as error:
        raise RecordingError(f'cannot be read: {error.strerror}', where=path) from error
    marked = next((name for mark, name in MARKS if head.startswith(mark)), None)
    for name in (marked,) if marked else _likely(head):
        try:
            text = codecs.getincrementaldecoder(name)().decode(head, len(head) < HEAD_BYTES)
        except UnicodeDecodeError:
            continue
        if all(letter >= ' ' or letter in LINES for letter in text) and '\x7f' not in text:
            return name
    raise RecordingError('not a text file', where=path, expected='a table in UTF-8')


def _likely(head: bytes) -> tuple[str, ...]:
    # Digits in UTF-16 have every second byte zero.
    if head[1::2].count(0) > len(head) // 4:
        return ('utf-16-le',)
    if head[::2].count(0) > len(head) // 4:
        return ('utf-16-be',)
    return ('utf-8', 'cp1252')
