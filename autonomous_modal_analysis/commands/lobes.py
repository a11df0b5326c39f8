"""`ama lobes`: spindle speed, depth and feed of a cut that does not chatter."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import typer

from autonomous_modal_analysis.option_groups import grouped
from autonomous_modal_analysis.options import Json
from machining.cut_settings import CutSettings, KINDS


@dataclass(frozen=True, slots=True)
class Wanted:
    """A file of the cut, and what is given beside it."""

    cut: Annotated[Path | None, typer.Option(help='YAML file with any of the settings below.')] = (
        None
    )
    changes: dict[str, Any] = field(
        default_factory=dict, metadata={'changes': CutSettings, 'without': ()}
    )


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('lobes')(grouped(lobes))


def lobes(
    wanted: Wanted,
    tool: Annotated[
        Path,
        typer.Argument(
            help='Modes at the tool with their masses (YAML, JSON of a map, modes.json of ama '
            'impact), or a table of its frequency response (.csv).',
            show_default=False,
        ),
    ],
    tool_channels: Annotated[
        str | None,
        typer.Option(
            help='Of a tap test: channels along x, y and z of the tool, separated by commas; - '
            'where there is none.'
        ),
    ] = None,
    response: Annotated[
        str, typer.Option(help=f'What a table holds: {", ".join(KINDS)}.')
    ] = KINDS[0],
    out: Annotated[
        Path | None, typer.Option(help='Folder for lobes.json, lobes.csv and report.html.')
    ] = None,
    json: Json = False,
) -> None:
    """Find the depths at which a cut chatters over spindle speed, and propose cuts that do not.

    The more is known of how sure modes and coefficients are, the better the chance of chatter.
    """
    from autonomous_modal_analysis.api.lobes import lobes as stability_lobes
    from autonomous_modal_analysis.lobes_report import FILES, show_lobes
    from autonomous_modal_analysis.output import show_written
    from autonomous_modal_analysis.terminal import print_json, progress_bar

    with progress_bar('limits of samples') as progress:
        result = stability_lobes(
            tool,
            wanted.cut,
            tool_channels=[name.strip() for name in (tool_channels or '').split(',') if name],
            response=response,
            progress=progress,
            **wanted.changes,
        )
    if json:
        print_json(result.to_dict())
    else:
        show_lobes(result.found, result.name)
    if out is not None:
        result.save(out)
        show_written(out, FILES)
