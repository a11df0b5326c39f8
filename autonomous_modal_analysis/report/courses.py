"""Modes over joint speed, load and pose: one table of all recordings, and a picture of each."""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from autonomous_modal_analysis.compared.mode_courses import CoursePoint
from autonomous_modal_analysis.compared.operating_state import differing, NUMBER, OperatingState
from modal_core.mode import Mode
from modal_reports import (
    Cell,
    DAMPING,
    fixed,
    FREQUENCY,
    measured,
    number,
    over_state,
    percent,
    Quantity,
    Row,
    StatePoint,
    Table,
    tags,
    text,
)

MOST_AXES, MOST_DRAWN = 2, 12
"""States that modes are drawn over, and modes that are drawn: more would not be looked at."""


@dataclass(frozen=True, slots=True)
class CoursesShown:
    """What the section shows.

    Parameters
    ----------
    states : tuple of str
        Recordings with what is known of their states, one line each.
    table : Table
        One row per mode and recording.
    pictures : tuple of Markup
        Frequency, then damping ratio, of each mode over what states differ in.
    """

    states: tuple[str, ...]
    table: Table
    pictures: tuple[Markup, ...]


def courses_shown(
    names: Sequence[str],
    states: Sequence[OperatingState],
    courses: Sequence[tuple[CoursePoint, ...]],
) -> CoursesShown:
    """Return the section of several recordings.

    Parameters
    ----------
    names : sequence of str
        Of the recordings, the first first.
    states : sequence of OperatingState
        Of the same.
    courses : sequence of tuple of CoursePoint
        One per mode of the first recording.
    """
    axes = differing(states)[:MOST_AXES]
    shown = [axis for axis in axes if axis[0] != NUMBER]
    known = zip(names, states, strict=True)
    return CoursesShown(
        tuple(f'{name}: {state.words() or "state not known"}' for name, state in known),
        _table(names, shown, courses),
        tuple(
            _picture(quantity, axis, names, course)
            for course in courses[:MOST_DRAWN]
            if len(course) > 1
            for axis in axes
            for quantity in (FREQUENCY, DAMPING)
        ),
    )


def _table(
    names: Sequence[str],
    axes: Sequence[tuple[str, list[float]]],
    courses: Sequence[tuple[CoursePoint, ...]],
) -> Table:
    headings = [
        text('Recording'),
        *(number(name[:1].upper() + name[1:]) for name, _ in axes),
        Cell(FREQUENCY.heading, 'number', 2),
        number('Change %'),
        number('In σ'),
        Cell(DAMPING.heading, 'number', 2),
        number('Change in σ'),
        text(''),
    ]
    rows = [_row(point, names, axes) for course in courses for point in course]
    return Table('Modes through all recordings', headings, rows, empty='no modes')


def _row(point: CoursePoint, names: Sequence[str], axes: Sequence[tuple[str, list[float]]]) -> Row:
    mode, change = point.mode, point.change
    moved = (
        ('', '', '')
        if change is None
        else (
            percent(change.frequency_change, 2, sign=True).removesuffix(' %'),
            fixed(change.frequency_surprise, 1, sign=True),
            fixed(change.damping_surprise, 1, sign=True),
        )
    )
    marks = (
        ()
        if change is None
        else (
            ('changed' if change.is_significant else '', 'bad'),
            ('shape changed' if change.is_shape_changed else '', 'doubt'),
        )
    )
    return Row(
        [
            text(names[point.recording]),
            *(number(f'{values[point.recording]:.3g}') for _, values in axes),
            *measured(FREQUENCY, mode.frequency_hz, mode.frequency_std_hz),
            number(moved[0]),
            number(moved[1]),
            *measured(DAMPING, mode.damping_ratio, mode.damping_ratio_std),
            number(moved[2]),
            tags(*marks),
        ]
    )


def _picture(
    quantity: Quantity,
    axis: tuple[str, list[float]],
    names: Sequence[str],
    course: tuple[CoursePoint, ...],
) -> Markup:
    name, values = axis
    points = [
        StatePoint(values[point.recording], value, std, f'{names[point.recording]}: {words}')
        for point in course
        for value, std, words in [_value(quantity, point.mode)]
    ]
    first = FREQUENCY.text(course[0].mode.frequency_hz)
    return over_state(f'mode of {first}', (name, quantity.label), points)


def _value(quantity: Quantity, mode: Mode) -> tuple[float, float, str]:
    """Return a value and its deviation in the quantity's unit, and both in words."""
    if quantity is FREQUENCY:
        value, std = mode.frequency_hz, mode.frequency_std_hz
    else:
        value, std = mode.damping_ratio, mode.damping_ratio_std
    return quantity.factor * value, quantity.factor * std, quantity.text(value, std)
