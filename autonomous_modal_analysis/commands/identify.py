"""`ama identify`: the modes of a recording."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.option_groups import grouped, Identifier, Source
from autonomous_modal_analysis.options import Json


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('identify')(grouped(identify))


def identify(
    source: Source,
    identifier: Identifier,
    out: Annotated[
        Path | None, typer.Option(help='Folder for modes.json, modes.csv and report.html.')
    ] = None,
    json: Json = False,
) -> None:
    """Identify natural frequencies, damping ratios and mode shapes of a recording.

    No setting is required: band, model orders, references and the choice of modes follow from
    the data.
    """
    from autonomous_modal_analysis.output import show_damage, show_identification, show_written
    from autonomous_modal_analysis.terminal import print_json, progress_bar

    recording = source.open()
    with progress_bar(f'identifying {recording.name}') as progress:
        result = identifier.identify(recording, progress)
    show_damage(result.damage)
    if json:
        print_json(result.to_dict())
    else:
        show_identification(result.found, result.name)
    if out is not None:
        result.save(out)
        show_written(out)
