"""Modes over the level of their motion: their laws in a table, frequencies in pictures."""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from autonomous_modal_analysis.compared.mode_levels import ModeLevels
from autonomous_modal_analysis.report.courses import MOST_DRAWN
from autonomous_modal_analysis.views.level_view import added_at_largest, level_notes, moves_mm
from modal_reports import (
    FREQUENCY,
    measured,
    number,
    over_state,
    Row,
    StatePoint,
    Table,
    text,
)
from modal_reports.words import capital
from oma_identifier.levels import LevelLaw


@dataclass(frozen=True, slots=True)
class LevelsShown:
    """What the section shows.

    Parameters
    ----------
    table : Table
        One row per mode with a law.
    notes : tuple of str
        Modes without one, and why; what else is to be known.
    pictures : tuple of Markup
        Frequency of each mode over its motion.
    """

    table: Table
    notes: tuple[str, ...]
    pictures: tuple[Markup, ...]


def levels_shown(names: Sequence[str], levels: Sequence[ModeLevels]) -> LevelsShown:
    """Return the section of modes over levels.

    Parameters
    ----------
    names : sequence of str
        Of the recordings.
    levels : sequence of ModeLevels
        One per mode of the first.
    """
    headings = [
        *(number(heading) for heading in (FREQUENCY.heading, '')),
        text('At'),
        number('Moves [mm rms]'),
        number('Stiffness % at the largest'),
        text('Law'),
        number('Damping % at the largest'),
        text('Law'),
    ]
    rows = [_row(each, each.law) for each in levels if each.law is not None]
    return LevelsShown(
        Table('Modes over the level of their motion', headings, rows, empty='no law'),
        tuple(f'{line}.' for line in level_notes(levels)),
        tuple(_picture(names, each) for each in levels[:MOST_DRAWN] if each.points),
    )


def _row(levels: ModeLevels, law: LevelLaw) -> Row:
    stiffness, damping = added_at_largest(levels, law)
    return Row(
        [
            *measured(FREQUENCY, law.mode.frequency_hz, law.frequency_std_hz),
            text(levels.channel),
            number(moves_mm(levels)),
            number(stiffness),
            text(capital(law.stiffness.words)),
            number(damping),
            text(capital(law.damping.words)),
        ]
    )


def _picture(names: Sequence[str], levels: ModeLevels) -> Markup:
    points = [
        StatePoint(
            1e3 * motion.displacement_m,
            mode.frequency_hz,
            mode.frequency_std_hz,
            f'{names[at]}: {FREQUENCY.text(mode.frequency_hz, mode.frequency_std_hz)}',
        )
        for at, mode, motion in levels.points
    ]
    title = f'mode of {FREQUENCY.text(levels.mode.frequency_hz)} at {levels.channel}'
    return over_state(title, ('motion [mm rms]', FREQUENCY.label), points)
