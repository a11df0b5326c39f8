"""Which columns of a table are angles, speeds and torques of a robot's joints."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
import math
from pathlib import Path
import re

from modal_core.errors import RecordingError
from modal_recordings.tables.heading import Heading


class Told(Enum):
    """What a column tells of a joint."""

    POSITION = 'position'
    VELOCITY = 'velocity'
    EFFORT = 'effort'


WORDS = {
    Told.POSITION: frozenset('position positions pos angle angles q theta'.split()),
    Told.VELOCITY: frozenset('velocity velocities vel speed dq qd qdot omega dtheta'.split()),
    Told.EFFORT: frozenset('effort efforts torque torques tau trq force'.split()),
}
NEUTRAL = frozenset('joint joints j axis axes motor actual measured state states'.split())
"""Words beside those: what they are of, and how they came to be known."""
OF_JOINTS = frozenset('q qd qdot dq tau theta dtheta angle angles joint joints'.split())
"""Words that a response is not called by."""
OF_SUFFIX = {'rad': 'rad', 'deg': 'deg', 'nm': 'nm', 'm': 'm', 'mm': 'mm'}
"""Units that may end a name without brackets, as in ``q1_deg``."""
TO_SI = {
    Told.POSITION: {
        'rad': 1.0,
        'mrad': 1e-3,
        'deg': math.pi / 180.0,
        '°': math.pi / 180.0,
        'm': 1.0,
        'mm': 1e-3,
    },
    Told.VELOCITY: {
        'rad/s': 1.0,
        'mrad/s': 1e-3,
        'deg/s': math.pi / 180.0,
        '°/s': math.pi / 180.0,
        'dps': math.pi / 180.0,
        'm/s': 1.0,
        'mm/s': 1e-3,
    },
    Told.EFFORT: {'nm': 1.0, 'n*m': 1.0, 'n m': 1.0, 'n': 1.0, 'knm': 1e3, 'kn': 1e3},
}


@dataclass(frozen=True)
class JointColumn:
    """A column that tells of a joint.

    Parameters
    ----------
    column : int
        Of the table.
    factor : float
        To radians, metres, their rates, or newton metres.
    """

    column: int
    factor: float


@dataclass(frozen=True)
class JointColumns:
    """The columns of the joints, each list in the robot's order; empty: not there.

    Parameters
    ----------
    position, velocity, effort : tuple of JointColumn
    """

    position: tuple[JointColumn, ...]
    velocity: tuple[JointColumn, ...] = ()
    effort: tuple[JointColumn, ...] = ()

    @property
    def all(self) -> tuple[JointColumn, ...]:
        """Every one of them."""
        return self.position + self.velocity + self.effort


@dataclass(frozen=True)
class _Place:
    """A column that names a joint: which, in which words beside it, and what it may tell."""

    joint: int
    words: tuple[str, ...]
    told: Told | None
    found: JointColumn


def joint_columns_of(
    path: Path, headings: Sequence[Heading], joint_names: Sequence[str]
) -> JointColumns | None:
    """Tell which columns are those of the joints.

    They have the joints' names, with or without a word that says what they tell
    (``joint_2_velocity``, ``tau/joint_2``), or count the joints in the robot's order from 0 or 1
    (``q1``, ``dq1``, ``tau1``).  A unit decides what is told; without one angles are in radians.

    Parameters
    ----------
    path : Path
        For errors.
    headings : sequence of Heading
        Of all columns.
    joint_names : sequence of str
        Of the robot.

    Returns
    -------
    JointColumns or None
        None where no set of columns tells the position of every joint.

    Raises
    ------
    RecordingError
        Two sets of columns tell the same.
    """
    by_name = [_named(column, it, joint_names) for column, it in enumerate(headings)]
    named = [place for place in by_name if place is not None]
    counted = [
        place
        for column, heading in enumerate(headings)
        if by_name[column] is None and (place := _counted(column, heading)) is not None
    ]
    sets = _whole(named, range(len(joint_names)))
    for first in (0, 1):
        for told, columns in _whole(counted, range(first, first + len(joint_names))).items():
            sets.setdefault(told, []).extend(columns)
    chosen = {told: _only(path, told, found, headings) for told, found in sets.items()}
    if Told.POSITION not in chosen:
        return None
    empty: tuple[JointColumn, ...] = ()
    return JointColumns(
        chosen[Told.POSITION], chosen.get(Told.VELOCITY, empty), chosen.get(Told.EFFORT, empty)
    )


def is_of_joints(name: str) -> bool:
    """Tell whether a column or array is called as angles, speeds or torques of joints are.

    ``q``, ``q1``, ``joint_positions``; a joint's own name does not tell without its robot.
    """
    words = {word for word in _split_name(name) if not word.isdigit()}
    known = NEUTRAL.union(OF_SUFFIX, *WORDS.values())
    return bool(words & OF_JOINTS) and words <= known and words != {'joint'}


def _only(
    path: Path,
    told: Told,
    found: list[tuple[JointColumn, ...]],
    headings: Sequence[Heading],
) -> tuple[JointColumn, ...]:
    if len(found) > 1:
        raise RecordingError(
            f'two columns tell the {told.value} of a joint',
            where=path,
            found=', '.join(headings[columns[0].column].name for columns in found),
            advice='name one of them otherwise, or leave it out with "-" among channels',
        )
    return found[0]


def _whole(places: Sequence[_Place], joints: range) -> dict[Told, list[tuple[JointColumn, ...]]]:
    """Return the sets of columns, of one wording each, that tell of every joint once."""
    groups: dict[tuple[tuple[str, ...], Told | None], dict[int, list[JointColumn]]] = {}
    for place in places:
        group = groups.setdefault((place.words, place.told), {})
        group.setdefault(place.joint, []).append(place.found)
    found: dict[Told, list[tuple[JointColumn, ...]]] = {}
    for (_, told), group in groups.items():
        once = all(len(group.get(joint, ())) == 1 for joint in joints)
        if told is not None and once and len(group) == len(joints):
            found.setdefault(told, []).append(tuple(group[joint][0] for joint in joints))
    return found


def _named(column: int, heading: Heading, joint_names: Sequence[str]) -> _Place | None:
    """Return what a column tells whose name has a joint's name in it."""
    words, unit = _split(heading)
    for joint, name in enumerate(joint_names):
        own = _split_name(name)
        for first in range(len(words) - len(own) + 1):
            if words[first : first + len(own)] != own:
                continue
            before, behind = words[:first], words[first + len(own) :]
            # A robot's name may stand before its joints', apart from them: robot/joint_1.
            prefix = before if re.search(r'[/.]', heading.name) else ()
            return _place(column, joint, before + behind, unit, prefix)
    return None


def _counted(column: int, heading: Heading) -> _Place | None:
    """Return what a column tells whose name is a word and a number."""
    words, unit = _split(heading)
    numbers = [word for word in words if word.isdigit()]
    rest = tuple(word for word in words if not word.isdigit())
    return _place(column, int(numbers[0]), rest, unit) if len(numbers) == 1 and rest else None


def _place(
    column: int, joint: int, words: tuple[str, ...], unit: str, prefix: tuple[str, ...] = ()
) -> _Place | None:
    told = [kind for kind, known in WORDS.items() if known.intersection(words)]
    strange = [
        word
        for word in words
        if word not in NEUTRAL and not any(word in known for known in WORDS.values())
    ]
    if len(told) > 1 or any(word not in prefix for word in strange):
        return None
    kinds = [kind for kind, factors in TO_SI.items() if unit in factors] if unit else []
    if unit and (not kinds or (told and told[0] not in kinds)):
        return None
    kind = told[0] if told else kinds[0] if kinds else Told.POSITION
    return _Place(joint, words, kind, JointColumn(column, TO_SI[kind].get(unit, 1.0)))


def _split(heading: Heading) -> tuple[tuple[str, ...], str]:
    """Return the words of a heading in small letters, and its unit."""
    words, unit = _split_name(heading.name), heading.unit_text.strip().lower()
    if not unit and len(words) > 1 and words[-1] in OF_SUFFIX:
        return words[:-1], OF_SUFFIX[words[-1]]
    return words, unit


def _split_name(name: str) -> tuple[str, ...]:
    apart = re.sub(r'(?<=[a-z])(?=[A-Z])|(?<=[A-Za-z])(?=\d)', ' ', name).lower()
    return tuple(re.findall(r'[^\W_]+', apart))
