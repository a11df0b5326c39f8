"""Sentences: counted nouns, lists, lengths of time."""

from collections.abc import Sequence


def count(number: int, noun: str) -> str:
    """Return a number with its noun in the right number."""
    return f'{number} {noun}' if number == 1 else f'{number} {noun}s'


def duration(seconds: float) -> str:
    """Return a length of time in the unit a person would choose."""
    if seconds < 120.0:
        return f'{seconds:.3g} s of data'
    if seconds < 7200.0:
        return f'{seconds / 60.0:.3g} min of data'
    return f'{seconds / 3600.0:.3g} h of data'


def listed(names: Sequence[str], most: int = 5) -> str:
    """Return names in a row, the last behind an *and*; of more than so many the first."""
    shown = list(names[:most])
    if len(names) > most:
        shown.append(f'{len(names) - most} more')
    return shown[0] if len(shown) == 1 else f'{", ".join(shown[:-1])} and {shown[-1]}'


def capital(text: str) -> str:
    """Return the text with a capital at its beginning."""
    return text[:1].upper() + text[1:]
