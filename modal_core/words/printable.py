"""Text from elsewhere, made fit for a terminal, a log, or one line of either."""

from typing import Any

CUT = ' ... '
MOST_BREAKS = 20
"""Of lines in one text, chosen: a page is no place for a file."""


def printable(text: object, most: int | None = None) -> str:
    r"""Return text without anything that steers a terminal or hides what is written.

    Control characters (escape sequences begin with one), reversals and overrides of the writing
    direction, invisible and unpaired characters become their escapes, such as ``\x1b``.

    Parameters
    ----------
    text : object
        What somebody else wrote: a channel, a frame, a topic, a file name, a cell.
    most : int or None
        Characters to keep, the middle is left out of more; None: all.
    """
    words = str(text)
    if most is not None and len(words) > most:
        half = (most - len(CUT)) // 2
        words = words[:half] + CUT + words[-half:]
    if words.isprintable():
        return words
    return ''.join(_shown(letter) for letter in words)


def printable_values(value: Any, most: int | None = None) -> Any:
    """Return plain values (of JSON) with every text in them as :func:`printable` has it.

    A page shows line breaks of its own words; they steer nothing there.
    """
    if isinstance(value, str):
        return '\n'.join(printable(line, most) for line in value.split('\n', MOST_BREAKS))
    if isinstance(value, dict):
        return {
            printable_values(key, most): printable_values(each, most)
            for key, each in value.items()
        }
    if isinstance(value, list | tuple):
        return [printable_values(each, most) for each in value]
    return value


def _shown(letter: str) -> str:
    # Spaces other than the plain one are not "printable", and harmless.
    if letter.isprintable() or (
        letter.isspace() and letter >= '\xa0' and letter not in '\u2028\u2029'
    ):
        return letter
    return letter.encode('unicode_escape').decode('ascii')
