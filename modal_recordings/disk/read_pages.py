"""Pages of a mapped file given back once they were read: memory does not grow with the file."""

import mmap

import numpy as np
from numpy.typing import NDArray

AT_ONCE_BYTES = 4 * 2**20


class ReadPages:
    """Gives back the pages of a mapped file once they were read.

    The operating system counts every page that was touched as memory of the process for as long
    as the file is mapped.  A page given back is read from the file again should it be needed.

    Parameters
    ----------
    mapped : mmap.mmap or None
        Of a file, not written to; None: nothing is mapped and nothing is given back.
    """

    def __init__(self, mapped: mmap.mmap | None) -> None:
        # Not every system has the call, and those without it count such pages otherwise.
        self._mapped = mapped if hasattr(mmap, 'MADV_DONTNEED') else None
        self._n_read = 0

    @classmethod
    def behind(cls, values: NDArray[np.generic]) -> 'ReadPages':
        """Return those behind an array, which may be a memory map or none."""
        mapped = getattr(values, '_mmap', None)
        return cls(mapped if isinstance(mapped, mmap.mmap) else None)

    def read(self, n_bytes: int) -> None:
        """Note that so many bytes more were read; some megabytes are given back at once."""
        self._n_read += n_bytes
        if self._mapped is not None and self._n_read >= AT_ONCE_BYTES:
            self._mapped.madvise(mmap.MADV_DONTNEED)
            self._n_read = 0
