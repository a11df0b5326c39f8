"""`ama compare`: the modes of recordings, such as at rest and at work, and what changed."""

from collections.abc import Sequence
from dataclasses import replace
import math
from pathlib import Path
from typing import Annotated, TYPE_CHECKING

import typer

from autonomous_modal_analysis.console.option_groups import grouped, Identifier, Reading
from autonomous_modal_analysis.console.options import ExportTable, Json

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.modal_result import ModalResult
    from autonomous_modal_analysis.compared.mode_courses import CoursePoint
    from autonomous_modal_analysis.compared.mode_levels import ModeLevels

REPORT = 'comparison.html'


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('compare')(grouped(compare))


def compare(
    recordings: Annotated[
        list[Path],
        typer.Argument(
            help='Recordings, results of `ama identify`, or universal files with modes: the first,'
            ' then those to compare with it.',
            show_default=False,
        ),
    ],
    reading: Reading,
    identifier: Identifier,
    out: Annotated[Path | None, typer.Option(help='Folder for comparison.html.')] = None,
    load_kg: Annotated[
        str | None,
        typer.Option(help='Load of each recording in their order \\[kg], separated by commas.'),
    ] = None,
    levels: Annotated[
        bool,
        typer.Option(
            '--levels',
            help='Recordings at three levels of excitation or more: cubic stiffness, cubic damping'
            ' or friction of each mode.',
        ),
    ] = False,
    export: ExportTable = None,
    json: Json = False,
) -> None:
    """Compare the modes of recordings with those of the first: at rest and at work.

    Modes are paired by frequency and shape; each change is told from scatter by the standard
    deviations of both.
    """
    from autonomous_modal_analysis.compared.mode_courses import mode_courses
    from autonomous_modal_analysis.console.terminal import print_json
    from autonomous_modal_analysis.export import check_endings, export_table, TABLE_ENDINGS
    from autonomous_modal_analysis.read_results import read_result
    from autonomous_modal_analysis.report import ComparedState, StateDrawn, write_comparison
    from autonomous_modal_analysis.views.change_view import changes_json, show_summary
    from autonomous_modal_analysis.views.course_view import (
        courses_json,
        courses_table,
        show_courses,
    )
    from autonomous_modal_analysis.views.level_view import levels_json, show_levels
    from autonomous_modal_analysis.views.output import export_each, show_written
    from modal_core.errors import SettingsError
    from oma_identifier.compare import compare_modes

    if len(recordings) < 2:
        raise SettingsError(
            'there is nothing to compare with', where='ama compare', expected='two'
        )
    check_endings(export or (), TABLE_ENDINGS)
    first, *others = recordings
    loads = _loads(load_kg, len(recordings))
    base = read_result(first, identifier, reading)
    base = replace(base, at=replace(base.at, load_kg=loads[0]))
    drawing = base.result.drawing() if base.result is not None and out is not None else None
    states, results = [], [base.result]
    for path, load in zip(others, loads[1:], strict=True):
        other = read_result(path, identifier, reading)
        results.append(other.result)
        at = replace(other.at, load_kg=load)
        found = compare_modes(base.modes, other.modes)
        on_arm = base.result.drawing(other.modes) if base.result and drawing else None
        drawn = StateDrawn(other.spectrum, on_arm)
        states.append(ComparedState(path.name, other.modes, found, drawn, at))
    _tell_twice(recordings)
    courses = mode_courses(base.modes, [state.found for state in states])
    named = [first.name, *(state.name for state in states)]
    at_all = [base.at, *(state.at for state in states)]
    over_levels = _over_levels(recordings, results, courses) if levels else None
    if json:
        said = changes_json(first.name, states) | courses_json(named, at_all, courses)
        print_json(said | (levels_json(named, over_levels) if over_levels is not None else {}))
    else:
        show_courses(named, at_all, courses)
        for state in states:
            show_summary(state.found, first.name, state.name)
        if over_levels is not None:
            show_levels(over_levels)
    alone = [state.found.only_second for state in states]
    export_each(
        export, lambda file: export_table(file, courses_table(named, at_all, courses, alone))
    )
    if out is not None:
        drawn = StateDrawn(base.spectrum, drawing)
        write_comparison(out / REPORT, first.name, base.modes, states, drawn, base.at, over_levels)
        show_written(out, (REPORT,))


def _tell_twice(recordings: Sequence[Path]) -> None:
    """Say which recordings are given twice: from one to itself nothing changes."""
    from rich.markup import escape

    from autonomous_modal_analysis.console.terminal import MESSAGES
    from modal_core.files.real_path import real_path

    places = [real_path(path) for path in recordings]
    for path in dict.fromkeys(path for path in recordings if places.count(real_path(path)) > 1):
        MESSAGES.print(f'note: the same recording twice: {escape(str(path))}', soft_wrap=True)


def _over_levels(
    recordings: Sequence[Path],
    results: Sequence['ModalResult | None'],
    courses: Sequence[tuple['CoursePoint', ...]],
) -> list['ModeLevels']:
    """Return modes over levels; kept results do not say how far a mode moved."""
    from autonomous_modal_analysis.compared.mode_levels import mode_levels
    from modal_core.errors import SettingsError

    known = [result for result in results if result is not None]
    if len(known) < len(results):
        path = recordings[results.index(None)]
        raise SettingsError(
            'kept modes do not say how far they moved',
            where='--levels',
            found=path.name,
            expected='recordings',
        )
    return mode_levels(known, courses)


def _loads(text: str | None, n_recordings: int) -> tuple[float, ...]:
    """Return the load of each recording, NaN where none is stated."""
    from autonomous_modal_analysis.console.options import numbers
    from modal_core.errors import SettingsError

    if text is None:
        return (math.nan,) * n_recordings
    loads = numbers(text, '--load-kg')
    if len(loads) != n_recordings:
        raise SettingsError(
            'one load for each recording',
            where='--load-kg',
            found=len(loads),
            expected=n_recordings,
        )
    return loads
