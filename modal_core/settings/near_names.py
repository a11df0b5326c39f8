"""Refuse a name that is not known, and tell the ones that come nearest to it."""

from collections.abc import Iterable
from difflib import get_close_matches

from modal_core.errors import ModalAnalysisError, SettingsError

ALL_SHOWN = 20
"""Of so many known names all are told when none is near."""
N_NEAREST = 3
"""Of those that are told: as many as one line takes in."""
ALIKE = 0.6
"""Share of equal letters from which a name may be meant, as difflib's default."""
SLIP = 0.8
"""Share from which nothing else can be meant: a letter too many, missing or wrong in five."""


def refuse_unknown(
    names: Iterable[object],
    known: Iterable[str],
    what: str = 'unknown field',
    where: object = '',
    error: type[ModalAnalysisError] = SettingsError,
) -> None:
    """Refuse the first name that is not known.

    Parameters
    ----------
    names : iterable
        As they were given; of a file's keys any may be no text.
    known : iterable of str
        What there is.
    what, where : str, object
        Words of the error.
    error : type
        Which error.

    Raises
    ------
    ModalAnalysisError
        One is not known; it names the nearest.
    """
    there = tuple(known)
    for name in names:
        if name not in there:
            raise error(what, where=where, found=name, expected=near(str(name), there))


def misspelt(names: Iterable[object], known: Iterable[str]) -> tuple[list[str], list[str]]:
    """Sort unknown names of a file that others may have written in their own words.

    Returns
    -------
    tuple of two lists
        Names that can only be slips of a known one; names that are something else.
    """
    there = tuple(known)
    unknown = [str(name) for name in names if name not in there]
    slips = [name for name in unknown if get_close_matches(name, there, 1, SLIP)]
    return slips, [name for name in unknown if name not in slips]


def near(name: str, known: tuple[str, ...]) -> str:
    """Return the known names that may be meant; without any all of them, or some of very many."""
    alike = get_close_matches(name, known, N_NEAREST, ALIKE)
    # The same word in another group, as servo.bandwidth_hz for bandwidth_hz.
    last = name.rpartition('.')[2]
    alike += [item for item in known if item.rpartition('.')[2] == last and item not in alike]
    if alike:
        return ' or '.join(alike[:N_NEAREST])
    if len(known) <= ALL_SHOWN:
        return ', '.join(known)
    some = get_close_matches(name, known, N_NEAREST, 0.0)
    return f'one of {len(known)}, for example {", ".join(some)}'
