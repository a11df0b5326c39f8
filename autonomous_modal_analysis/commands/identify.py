"""`ama identify`: the modes of a recording."""

from pathlib import Path
from typing import Annotated, TYPE_CHECKING

import typer

from autonomous_modal_analysis.console.option_groups import grouped, Identifier, Source
from autonomous_modal_analysis.console.options import Export, Json
from autonomous_modal_analysis.identified.keeping import Keeping

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.modal_result import ModalResult


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('identify')(grouped(identify))


def identify(
    source: Source,
    identifier: Identifier,
    keeping: Keeping,
    others: Annotated[
        list[Path] | None,
        typer.Argument(
            help='Further recordings of the same sensors and pose, one per loading condition:'
            ' --method psdtm compares them.',
            show_default=False,
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help='Folder for modes.json, modes.csv and report.html.')
    ] = None,
    poles: Annotated[
        Path | None,
        typer.Option(
            help='Modes as they were picked in the report of this recording; the file it saved.'
        ),
    ] = None,
    export: Export = None,
    json: Json = False,
) -> None:
    """Identify natural frequencies, damping ratios and mode shapes of a recording.

    No setting is required: band, model orders, references and the choice of modes follow from
    the data.
    """
    from autonomous_modal_analysis.console.terminal import print_json, progress_bar
    from autonomous_modal_analysis.export import check_endings, ENDINGS
    from autonomous_modal_analysis.identified.loading_conditions import check_one, joined
    from autonomous_modal_analysis.identified.plan_record import recorded_robot_name
    from autonomous_modal_analysis.views.output import (
        export_each,
        show_damage,
        show_identification,
        show_kept,
        show_written,
    )

    check_endings(export or (), ENDINGS)
    check_one(1 + len(others or ()), identifier.settings.method)
    recording = joined([source.open(), *(source.open_file(path) for path in others or ())])
    # What the history lacks is said before the work.
    shift_ns = keeping.shift_ns(recording.info.start_ns, recording.name) if keeping.history else 0
    with progress_bar(f'identifying {recording.name}') as progress:
        result = identifier.identify(recording, progress)
    if poles is not None:
        result = result.choose(poles)
    show_damage(result.damage)
    if json:
        print_json(result.to_dict())
    else:
        show_identification(result.found, result.name)
    if out is not None:
        result.save(out)
        show_written(out)
    if identifier.settings.method == 'force':
        _tell_masses(result, out, json)
    export_each(export, result.export)
    if keeping.history is not None:
        robot = identifier.robot or recorded_robot_name(recording.source)
        told = keeping.circumstances(robot, result.found.identification.settings, source.recording)
        n_new = keeping.add(told, (*result.windows, result.found.whole), shift_ns)
        show_kept(keeping.history, n_new)


def _tell_masses(result: 'ModalResult', out: Path | None, json: bool) -> None:
    from autonomous_modal_analysis.views.force_view import (
        FILE,
        save_scaling,
        scaling_of,
        show_scaling,
    )
    from autonomous_modal_analysis.views.output import show_written

    scaling = scaling_of(result)
    if not json:
        show_scaling(scaling)
    if out is not None:
        save_scaling(out, scaling)
        show_written(out, (FILE,))
