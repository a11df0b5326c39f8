"""`ama compare`: the modes of recordings, such as at rest and at work, and what changed."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.option_groups import grouped, Identifier
from autonomous_modal_analysis.options import Json

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
    identifier: Identifier,
    out: Annotated[Path | None, typer.Option(help='Folder for comparison.html.')] = None,
    json: Json = False,
) -> None:
    """Compare the modes of recordings with those of the first: at rest and at work.

    Modes are paired by frequency and shape; each change is told from scatter by the standard
    deviations of both.
    """
    from autonomous_modal_analysis.change_view import changes_json, show_changes
    from autonomous_modal_analysis.output import show_written
    from autonomous_modal_analysis.read_results import read_result
    from autonomous_modal_analysis.report import ComparedState, StateDrawn, write_comparison
    from autonomous_modal_analysis.terminal import print_json
    from modal_core.errors import SettingsError
    from oma_identifier.compare import compare_modes

    if len(recordings) < 2:
        raise SettingsError(
            'there is nothing to compare with', where='ama compare', expected='two'
        )
    first, *others = recordings
    base = read_result(first, identifier)
    drawing = base.result.drawing() if base.result is not None and out is not None else None
    states = []
    for path in others:
        other = read_result(path, identifier)
        found = compare_modes(base.modes, other.modes)
        on_arm = base.result.drawing(other.modes) if base.result and drawing else None
        drawn = StateDrawn(other.spectrum, on_arm)
        states.append(ComparedState(path.name, other.modes, found, drawn))
    if json:
        print_json(changes_json(first.name, states))
    else:
        for state in states:
            show_changes(state.found, first.name, state.name)
    if out is not None:
        drawn = StateDrawn(base.spectrum, drawing)
        write_comparison(out / REPORT, first.name, base.modes, states, drawn)
        show_written(out, (REPORT,))
