"""Lists of names in words."""

from collections.abc import Sequence

MOST_NAMED = 12
"""In an error or a note: what one still reads."""


def named(names: Sequence[str], most: int = MOST_NAMED) -> str:
    """Return names as a list in words, the first ``most`` of them one by one."""
    more = len(names) - most
    return ', '.join(names[:most]) + (f' and {more} more' if more > 0 else '')
