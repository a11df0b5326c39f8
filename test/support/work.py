"""Work as a count, which is the same on a busy machine."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import sys


@contextmanager
def counted_calls() -> Iterator[Callable[[], int]]:
    """Count calls of functions of this thread, Python's and C's, while the block runs."""
    count = 0

    def note(frame: object, event: str, argument: object) -> None:
        nonlocal count
        if event in ('call', 'c_call'):
            count += 1

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        yield lambda: count
    finally:
        sys.setprofile(before)
