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
    """Merge set-ups that share reference sensors into modes over all points.

    Sensors that stay in place have the same channel names in all set-ups, the others their own.
    A mode that some set-ups missed stays; recordings are asked for it at its pole.
    """
    from dataclasses import replace

    from autonomous_modal_analysis.output import merged_words, write_merged
    from autonomous_modal_analysis.read_results import modes_of, RESULTS, samples_of
    from autonomous_modal_analysis.results import Identification, identification_json, SetUps
    from autonomous_modal_analysis.terminal import MESSAGES, modes_table, OUTPUT, print_json
    from modal_core.channel import Channel
    from modal_core.errors import SettingsError
    from oma_identifier.compare import merge_modes, shared_channels

    if len(setups) < 2:
        raise SettingsError('nothing to merge', found=len(setups), expected='two set-ups or more')
    found = [modes_of(path, identifier) for path in setups]
    shared = shared_channels([modes.channel_names for modes in found])
    joined = merge_modes(
        found, lambda setup: samples_of(setups[setup], found[setup].channel_names)
    )
    numbered = (replace(mode, id=index + 1) for index, mode in enumerate(joined.modes))
    merged = replace(joined.modes, modes=tuple(numbered))
    names = tuple(path.parent.name if path.name == RESULTS else path.name for path in setups)
    layout = identifier.sensors()
    known = {channel.name: channel for channel in layout.channels} if layout else {}
    set_ups = SetUps(
        names,
        shared,
        tuple(tuple(names[k] for k in seen) for seen in joined.seen_in),
        tuple(tuple(names[k] for k in read) for read in joined.read_in),
        joined.frequency_scatter,
        joined.damping_scatter,
    )
    identification = Identification(
        modes=merged,
        channels=tuple(known.get(name, Channel(name)) for name in merged.channel_names),
        settings={'merging': 'PoSER, missing modes by PreGER', 'method': merged.method},
        set_ups=set_ups,
    )
    if json:
        print_json(identification_json(identification))
    else:
        title = f'{len(setups)} set-ups, {len(merged.channel_names)} channels'
        notes = [set_ups.words(index) for index in range(len(merged))]
        OUTPUT.print(modes_table(merged.modes, title, notes))
    MESSAGES.print('\n'.join(merged_words(merged, set_ups)), soft_wrap=True, markup=False)
    if out is not None:
        write_merged(out, identification, names)
