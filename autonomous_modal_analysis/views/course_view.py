"""Modes through several recordings in one table, over joint speed, load and pose."""

from collections.abc import Sequence
import math

from rich.markup import escape

from autonomous_modal_analysis.compared.mode_courses import CoursePoint
from autonomous_modal_analysis.compared.operating_state import differing, NUMBER, OperatingState
from autonomous_modal_analysis.console.terminal import narrow_table, OUTPUT
from autonomous_modal_analysis.export import Table
from autonomous_modal_analysis.identified.results import plain
from modal_core.files.version import software
from modal_core.mode import Mode
from modal_reports import DAMPING, fixed, FREQUENCY, percent

NAME_WIDTH, WIDTH, STATE_WIDTH = 14, 68, 6
"""Letters of a recording's name, of a row, and of each state that differs: of two, 80 in all."""
LIKENESS = ('MAC', 'by chance ≥')
"""What is shown where a terminal has room for it."""
MOST_STATES = 2
SHORT = {'joint speed [°/s]': '°/s', 'load [kg]': 'kg'}
NUMBERS = ('frequency_hz', 'frequency_std_hz', 'damping_ratio', 'damping_ratio_std', 'mpc')
CHANGES = ('frequency_change', 'frequency_surprise', 'damping_change', 'damping_surprise', 'mac')
Courses = Sequence[tuple[CoursePoint, ...]]


def show_courses(names: Sequence[str], states: Sequence[OperatingState], courses: Courses) -> None:
    """Print one row per mode and recording; the states in words above.

    Parameters
    ----------
    names : sequence of str
        Of the recordings, the first first.
    states : sequence of OperatingState
        Of the same.
    courses : sequence of tuple of CoursePoint
        One per mode.
    """
    for name, state in zip(names, states, strict=True):
        if state.words():
            OUTPUT.print(f'{name}: {state.words()}', soft_wrap=True, markup=False)
    axes = [axis for axis in differing(states) if axis[0] != NUMBER][:MOST_STATES]
    table = narrow_table('modes through all recordings')
    table.add_column('recording', max_width=NAME_WIDTH, no_wrap=True)
    heads = [SHORT.get(name, 'angle °') for name, _ in axes]
    left = OUTPUT.width - WIDTH - STATE_WIDTH * len(axes)
    likeness = LIKENESS[: sum(left >= width for width in (6, 18))]
    for heading in (*heads, 'Hz', 'Δ %', '/σ', 'ζ %', '/σ', '', *likeness):
        table.add_column(heading, justify='right', no_wrap=True)
    for course in courses:
        for point in course:
            where = [f'{values[point.recording]:.3g}' for _, values in axes]
            table.add_row(escape(names[point.recording]), *where, *_cells(point, len(likeness)))
        table.add_section()
    OUTPUT.print(table)


def _cells(point: CoursePoint, n_likeness: int) -> tuple[str, ...]:
    mode, change = point.mode, point.change
    hz = FREQUENCY.number(mode.frequency_hz, mode.frequency_std_hz)
    ratio = DAMPING.number(mode.damping_ratio, mode.damping_ratio_std)
    if change is None:
        return hz, '', '', ratio, '', '', *[''] * n_likeness
    return (
        hz,
        percent(change.frequency_change, 2, sign=True).removesuffix(' %'),
        fixed(change.frequency_surprise, 1, sign=True),
        ratio,
        fixed(change.damping_surprise, 1, sign=True),
        '*' * change.is_significant + '~' * change.is_shape_changed,
        *(fixed(value, 3) for value in (change.mac, change.expected_mac.least)[:n_likeness]),
    )


def courses_table(
    names: Sequence[str],
    states: Sequence[OperatingState],
    courses: Courses,
    alone: Sequence[tuple[Mode, ...]],
) -> Table:
    """Return one row per mode and recording, with the changes from the first.

    Parameters
    ----------
    names, states, courses
        As for :func:`show_courses`.
    alone : sequence of tuple of Mode
        Of each further recording, the modes that are none of the first: mode 0.
    """
    rows = [(number, point) for number, course in enumerate(courses, start=1) for point in course]
    rows += [
        (0, CoursePoint(at, mode)) for at, modes in enumerate(alone, start=1) for mode in modes
    ]
    at = [states[point.recording] for _, point in rows]
    joints = states[0].joint_names
    same = all(state.joint_names == joints for state in states)
    columns: dict[str, list[object]] = {
        'mode': [number for number, _ in rows],
        'recording': [names[point.recording] for _, point in rows],
        'load_kg': [state.load_kg for state in at],
        'fastest_joint_deg_s': [state.fastest_deg_s for state in at],
    }
    for index, joint in enumerate(joints if same else ()):
        columns[f'angle_deg.{joint}'] = [float(state.angle_deg[index]) for state in at]
    for name in NUMBERS:
        columns[name] = [float(getattr(point.mode, name)) for _, point in rows]
    for name in CHANGES:
        columns[name] = [
            math.nan if point.change is None else float(getattr(point.change, name))
            for _, point in rows
        ]
    for name in ('is_significant', 'is_shape_changed'):
        columns[name] = [
            point.change is not None and bool(getattr(point.change, name)) for _, point in rows
        ]
    return Table.of(columns, {'recordings': ', '.join(names), 'software': software()})


def courses_json(
    names: Sequence[str], states: Sequence[OperatingState], courses: Courses
) -> dict[str, object]:
    """Return states and courses as plain values."""
    return {
        'recordings': [
            {
                'name': name,
                'joint_names': list(state.joint_names),
                'joint_angles_deg': plain(state.angle_deg),
                'joint_speeds_deg_s': plain(state.speed_deg_s),
                'load_kg': state.load_kg if math.isfinite(state.load_kg) else None,
            }
            for name, state in zip(names, states, strict=True)
        ],
        'courses': [
            [
                {
                    'recording': point.recording,
                    'frequency_hz': plain(point.mode.frequency_hz),
                    'frequency_std_hz': plain(point.mode.frequency_std_hz),
                    'damping_ratio': plain(point.mode.damping_ratio),
                    'damping_ratio_std': plain(point.mode.damping_ratio_std),
                }
                for point in course
            ]
            for course in courses
        ],
    }
