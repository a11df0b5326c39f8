"""Memory where it counts: freed memory given back to the operating system."""

from collections.abc import Callable
import ctypes
from functools import lru_cache
from typing import cast

LARGE_BYTES = 2**26
"""Size of a window's samples from where on memory counts more than some milliseconds."""


@lru_cache(maxsize=1)
def _trim() -> Callable[[int], int] | None:
    """Return the C library's own call; None where there is none, as on anything but Linux."""
    try:
        return cast(Callable[[int], int], ctypes.CDLL(None).malloc_trim)
    except (AttributeError, OSError, TypeError):
        return None


def give_back() -> None:
    """Give freed memory back.

    glibc keeps what arrays of up to 32 MB left behind, between what is still in use; step after
    step of an identification would add its own to that.
    """
    trim = _trim()
    if trim is not None:
        trim(0)
