"""What the heading of a column says: its name, its unit, and whether it is a time or a counter."""

from dataclasses import dataclass
import re

from modal_core.errors import RecordingError
from modal_core.units import known_unit, OTHER, RESPONSES, SECOND, Unit
from modal_core.words.printable import printable

LONGEST_NAME = 200
BRACKETED = re.compile(r'^(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*$')
LIKE_A_UNIT = re.compile(r'[/^²°%*]')
TIME_WORDS = frozenset(
    """time times timestamp stamp t zeit zeitstempel uhrzeit datum date datetime temps heure tiempo
    fecha hora tempo data ora tijd tid czas cas elapsed clock epoch millis seconds secs nanosec
    nanoseconds microseconds milliseconds timems timeus elapsedtime abszeit relzeit""".split()
) - {'data'}
COUNTER_WORDS = frozenset(
    """sample samples index idx n no nr num number count counter frame row record scan seq sequence
    packet id # i k lfd punkt messpunkt point step nummer numero""".split()
)
OTHER_WORDS = frozenset(
    """gyro gyros gyr gyroscope angular omega temp temperature temperatur mag magnetometer magnetic
    voltage velocity displacement rpm pressure humidity roll pitch yaw force hammer battery
    quaternion quat latitude longitude altitude""".split()
)
"""First words of names of what is no acceleration, unless a unit says what it is."""


@dataclass(frozen=True, slots=True)
class Heading:
    """One column as its heading describes it.

    Parameters
    ----------
    name : str
        Without the unit; empty when the column has none.
    unit : Unit or None
        None when none is stated.
    unit_text : str
        As written.
    """

    name: str
    unit: Unit | None = None
    unit_text: str = ''

    @property
    def words(self) -> tuple[str, ...]:
        """The name's words in lower case."""
        apart = re.sub(r'([a-z])([A-Z])', r'\1 \2', self.name).lower()
        return tuple(word for word in re.split(r'[\s_\-.,:/()\[\]]+', apart) if word)

    @property
    def is_time(self) -> bool:
        """Whether it is called a time, or in a unit of time."""
        if self.unit is not None:
            return self.unit.si == SECOND
        words = self.words
        return bool(words) and (words[0] in TIME_WORDS or words[-1] in TIME_WORDS)

    @property
    def is_counter(self) -> bool:
        """Whether it is called a number of the row."""
        return bool(self.words) and all(word in COUNTER_WORDS for word in self.words)

    @property
    def is_other(self) -> bool:
        """Whether it is called, or in a unit of, something that is no response."""
        if self.unit is not None:
            return self.unit.si == OTHER
        return bool(self.words) and self.words[0] in OTHER_WORDS


def heading_of(cell: str, unit: str, where: str) -> Heading:
    """Return what a heading says.

    Parameters
    ----------
    cell : str
        As written, with or without the unit in brackets or as the last word.
    unit : str
        What a row of units says of the column; empty when there is none.
    where : str
        Place to name in errors.

    Raises
    ------
    RecordingError
        The name is too long, or the unit is one nobody knows.
    """
    name, text = ' '.join(cell.split()), unit.strip().strip('[]() ')
    if len(name) > LONGEST_NAME or not name.isprintable():
        raise RecordingError(
            'bad name', where=where, found=printable(name, 60), expected='200 letters at most'
        )
    bracket = BRACKETED.match(name)
    if bracket:
        inside = (bracket.group(2) or bracket.group(3) or '').strip()
        if _is_unit(inside, where, square=bracket.group(2) is not None):
            name, text = bracket.group(1), inside
    name, text = _last_word(name, text)
    found = known_unit(text) if text not in ('', '-') else None
    if text not in ('', '-') and found is None:
        _refuse(text, where)
    # Sensor - axis: one word.
    return Heading(re.sub(r'\s*-\s*', '-', name), found, text)


def _is_unit(inside: str, where: str, square: bool) -> bool:
    """Tell a unit in brackets from a part of the name, such as (x) or [left]."""
    if known_unit(inside) is not None:
        # A lone letter in round brackets marks a sensor rather than ampere, kelvin or metre.
        return square or len(inside) > 1 or inside.lower() in 'gsh'
    if LIKE_A_UNIT.search(inside):
        _refuse(inside, where)
    return False


def _refuse(unit: str, where: str) -> None:
    raise RecordingError(
        'unknown unit',
        where=where,
        found=unit,
        expected=f'{", ".join(RESPONSES)}, or s, ms, us, ns',
    )


def _last_word(name: str, text: str) -> tuple[str, str]:
    """Take a unit from the end of the name: ``time_ms``, ``t us``, ``acc_x m/s^2``, or ``ms``."""
    parts = re.split(r'[\s_,]+', re.sub(r'([a-z])([A-Z])', r'\1_\2', name))
    last = known_unit(parts[-1])
    if text or last is None:
        return name, text
    if last.si == SECOND and (len(parts) == 1 or parts[0].strip('_').lower() in TIME_WORDS):
        # A column s or h alone may be any; ms or sec is not.
        return (name, parts[-1]) if len(parts) > 1 or len(name) > 1 else (name, text)
    if len(parts) > 1 and ('/' in parts[-1] or parts[-1].lower() in ('mg', 'dps', 'mps2', 'rpm')):
        return name[: -len(parts[-1])].rstrip(' _,'), parts[-1]
    return name, text
