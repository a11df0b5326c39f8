"""Walk through one serialised message whose parts have variable length."""

import struct
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import MessageError
from modal_core.measurements import NANOSECONDS_PER_SECOND

LONGEST_SEQUENCE = 4_000_000
LONGEST_NAME_LIST = 4096
MOST_KNOWN_LISTS = 64
# Every message of a topic repeats its names; the last list of each is found again by its bytes.
_known: dict[tuple[str, bool], tuple[bytes, tuple[str, ...]]] = {}


class Cursor:
    """Read a little-endian CDR or a ROS 1 message part by part, never past its end.

    Parameters
    ----------
    data : bytes
        The serialised message.
    where : str
        Topic, for error messages.
    ros1 : bool
        Packed without alignment or encapsulation, with a sequence number in the header.

    Raises
    ------
    MessageError
        From every method: the message ends early or is not little-endian CDR.

    Attributes
    ----------
    places : list of slice
        Bytes of the sequences of numbers read so far.
    """

    def __init__(self, data: bytes, where: str, *, ros1: bool = False) -> None:
        self.data = data
        self.where = where
        self.ros1 = ros1
        self.places: list[slice] = []
        self.position = 0 if ros1 else 4
        if not ros1 and data[:2] != b'\x00\x01':
            raise MessageError(
                'unknown encapsulation', where=where, found=data[:2].hex(), expected='0001'
            )

    def uint32(self) -> int:
        """Read an unsigned 32-bit number."""
        return int(self._number('<I', 4))

    def uint64(self) -> int:
        """Read an unsigned 64-bit number."""
        return int(self._number('<Q', 8))

    def float64(self) -> float:
        """Read a double."""
        return float(self._number('<d', 8))

    def stamp_ns(self) -> int:
        """Read the stamp of a header [ns]."""
        if self.ros1:
            self.uint32()
        seconds, nanoseconds = int(self._number('<i', 4)), self.uint32()
        if seconds < 0 or nanoseconds >= NANOSECONDS_PER_SECOND:
            raise MessageError(
                'invalid stamp',
                where=f'{self.where}: header.stamp',
                found=f'{seconds} s {nanoseconds} ns',
                expected='sec >= 0 and nanosec < 1000000000',
            )
        return seconds * NANOSECONDS_PER_SECOND + nanoseconds

    def text(self) -> str:
        """Read a string."""
        length = self.uint32()
        raw = self._take(length)
        return raw.rstrip(b'\x00').decode('utf-8', errors='replace')

    def texts(self) -> tuple[str, ...]:
        """Read a sequence of strings."""
        self._align(4)
        begin = self.position
        key = (self.where, self.ros1)
        raw, names = _known.get(key, (b'', ()))
        if raw and self.data.startswith(raw, begin):
            self.position += len(raw)
            return names
        count = self.uint32()
        if count > LONGEST_NAME_LIST:
            self._fail(f'{count} names', f'at most {LONGEST_NAME_LIST}')
        names = tuple(self.text() for _ in range(count))
        if len(_known) >= MOST_KNOWN_LISTS:
            _known.clear()
        _known[key] = self.data[begin : self.position], names
        return names

    def numbers(self, dtype: str) -> NDArray[np.generic]:
        """Read a sequence of numbers; a view of the message, not a copy."""
        count = self.uint32()
        if count > LONGEST_SEQUENCE:
            self._fail(f'{count} numbers', f'at most {LONGEST_SEQUENCE}')
        size = np.dtype(dtype).itemsize
        # CDR aligns the elements only when there are any.
        if count:
            self._align(size)
        self.places.append(slice(self.position, self.position + count * size))
        return np.frombuffer(self._take(count * size), dtype=dtype)

    def _number(self, code: str, size: int) -> float:
        self._align(size)
        if self.position + size > len(self.data):
            self._fail(f'{len(self.data)} bytes', 'more')
        (value,) = struct.unpack_from(code, self.data, self.position)
        self.position += size
        return value  # type: ignore[no-any-return]

    def _align(self, size: int) -> None:
        if not self.ros1:
            self.position += (4 - self.position) % size

    def _take(self, size: int) -> bytes:
        end = self.position + size
        if end > len(self.data):
            self._fail(f'{len(self.data)} bytes', f'at least {end}')
        part = self.data[self.position : end]
        self.position = end
        return part

    def _fail(self, found: str, expected: str) -> NoReturn:
        raise MessageError('malformed message', where=self.where, found=found, expected=expected)
