"""`ama merge`: the modes of several set-ups of roving sensors as one."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.console.option_groups import grouped, Identifier, Reading
from autonomous_modal_analysis.console.options import Export, Json


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('merge')(grouped(merge))


def merge(
    setups: Annotated[
        list[Path],
        typer.Argument(
            help='Recordings, or results of `ama identify`, one per set-up.', show_default=False
        ),
    ],
    reading: Reading,
    identifier: Identifier,
    out: Annotated[
        Path | None, typer.Option(help='Folder for modes.json and report.html.')
    ] = None,
    export: Export = None,
    json: Json = False,
) -> None:
    """Merge set-ups that share reference sensors into modes over all points.

    Sensors that stay in place have the same channel names in all set-ups, the others their own.
    A mode that some set-ups missed stays; recordings are asked for it at its pole.
    """
    from autonomous_modal_analysis.api.merge import merge as merged_set_ups
    from autonomous_modal_analysis.console.terminal import MESSAGES, OUTPUT, print_json
    from autonomous_modal_analysis.export import check_endings, ENDINGS
    from autonomous_modal_analysis.read_results import result_of
    from autonomous_modal_analysis.views.modes_table import modes_table
    from autonomous_modal_analysis.views.output import (
        export_each,
        JSON_NAME,
        merged_words,
        REPORT_NAME,
        show_written,
    )

    check_endings(export or (), ENDINGS)
    found = [result_of(path, identifier, reading) for path in setups]
    merged = merged_set_ups(found, layout=identifier.sensors())
    if json:
        print_json(merged.to_dict())
    else:
        title = f'{len(setups)} set-ups, {len(merged.channel_names)} channels'
        notes = [merged.set_ups.words(index) for index in range(len(merged))]
        OUTPUT.print(modes_table(merged.modes.modes, title, notes))
    words = merged_words(merged.modes, merged.set_ups)
    words += [f'note: {said}' for said in merged.identification.remarks]
    MESSAGES.print('\n'.join(words), soft_wrap=True, markup=False)
    if out is not None:
        merged.save(out)
        show_written(out, (JSON_NAME, REPORT_NAME))
    export_each(export, merged.export)
