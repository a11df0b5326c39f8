"""`ama merge`: the modes of several set-ups of roving sensors as one."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.option_groups import grouped, Identifier
from autonomous_modal_analysis.options import Json


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
    identifier: Identifier,
    out: Annotated[
        Path | None, typer.Option(help='Folder for modes.json and report.html.')
    ] = None,
    json: Json = False,
) -> None:
    """Merge set-ups that share reference sensors into modes over all points (PoSER).

    Sensors that stay in place have the same channel names in all set-ups, the others their own.
    """
    from dataclasses import replace

    from autonomous_modal_analysis.output import write_merged
    from autonomous_modal_analysis.read_results import modes_of
    from autonomous_modal_analysis.results import Identification, identification_json
    from autonomous_modal_analysis.terminal import MESSAGES, modes_table, OUTPUT, print_json
    from modal_core.channel import Channel
    from modal_core.errors import SettingsError
    from oma_identifier.compare import merge_modes, shared_channels

    if len(setups) < 2:
        raise SettingsError('nothing to merge', found=len(setups), expected='two set-ups or more')
    found = [modes_of(path, identifier) for path in setups]
    shared = shared_channels([modes.channel_names for modes in found])
    joined = merge_modes(found)
    merged = replace(
        joined, modes=tuple(replace(mode, id=number + 1) for number, mode in enumerate(joined))
    )
    layout = identifier.sensors()
    known = {channel.name: channel for channel in layout.channels} if layout else {}
    identification = Identification(
        modes=merged,
        channels=tuple(known.get(name, Channel(name)) for name in merged.channel_names),
        settings={'merging': 'PoSER', 'set-ups': [path.name for path in setups]},
    )
    if json:
        print_json(identification_json(identification))
    else:
        title = f'{len(setups)} set-ups, {len(merged.channel_names)} channels'
        OUTPUT.print(modes_table(merged.modes, title))
    counts = ', '.join(
        f'{len(modes)} in {path.name}' for modes, path in zip(found, setups, strict=True)
    )
    MESSAGES.print(
        f'{len(merged)} modes are in all set-ups ({counts}); shared: {", ".join(shared)}',
        soft_wrap=True,
        markup=False,
    )
    if out is not None:
        write_merged(out, identification, [path.name for path in setups])
