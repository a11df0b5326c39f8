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
    from autonomous_modal_analysis.identification import identify_recording
    from autonomous_modal_analysis.output import (
        show_damage,
        show_identification,
        write_results,
    )
    from autonomous_modal_analysis.results import identification_json
    from autonomous_modal_analysis.terminal import print_json, progress_bar

    settings, model, sensors = identifier.settings(), identifier.model(), identifier.sensors()
    recording, name = source.open(), source.recording.name
    with progress_bar(f'identifying {name}') as progress:
        found = identify_recording(recording, settings, sensors, progress, model)
    show_damage(found.identification.damage)
    if json:
        print_json(identification_json(found.identification))
    else:
        show_identification(found, name)
    if out is not None:
        drawing = None
        if model is not None and sensors is not None:
            from autonomous_modal_analysis.arm_drawing import draw_identified

            drawing = draw_identified(model, sensors, found.identification)
        write_results(out, found, name, drawing=drawing)
