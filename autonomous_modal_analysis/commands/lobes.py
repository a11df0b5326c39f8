"""`ama lobes`: spindle speed, depth, feed and pose of a cut that does not chatter."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import typer

from autonomous_modal_analysis.console.option_groups import grouped
from autonomous_modal_analysis.console.options import ExportTable, Json, POSE_HELP, Serial
from machining.cut_settings import CutSettings, KINDS
from modal_core.errors import SettingsError


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
            'impact), a table of its frequency response (.csv), or a map with --pose-deg.',
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
    pose_deg: Annotated[
        str | None, typer.Option(help=f'Of a map: the pose of the cut. {POSE_HELP}')
    ] = None,
    serial: Serial = False,
    turn_deg: Annotated[
        float,
        typer.Option(
            help='Of a map: the task leaves the tool free to turn about the spindle so far either'
            ' way; the best pose is proposed.'
        ),
    ] = 0.0,
    robot: Annotated[
        str, typer.Option(help='Of a map: robot of config/robots, or its folder.')
    ] = ('irb6660_205_190'),
    sensors: Annotated[
        str, typer.Option(help='Of a map: sensor layout of the robot.')
    ] = 'sensors',
    out: Annotated[
        Path | None, typer.Option(help='Folder for lobes.json, lobes.csv and report.html.')
    ] = None,
    export: ExportTable = None,
    json: Json = False,
) -> None:
    """Find the depths at which a cut chatters over spindle speed, and propose cuts that do not.

    The more is known of how sure modes and coefficients are, the better the chance of chatter.
    """
    from autonomous_modal_analysis.api.lobes import lobes as stability_lobes
    from autonomous_modal_analysis.api.lobes import MapPose
    from autonomous_modal_analysis.console.terminal import print_json, progress_bar
    from autonomous_modal_analysis.export import check_endings, TABLE_ENDINGS
    from autonomous_modal_analysis.lobes_report import FILES, show_lobes
    from autonomous_modal_analysis.views.output import export_each, show_written

    check_endings(export or (), TABLE_ENDINGS)
    if pose_deg is None and turn_deg:
        raise SettingsError('a turn from no pose', where='--turn-deg', advice='give --pose-deg')
    at = None
    if pose_deg is not None:
        at = MapPose(pose=pose_deg, serial=serial, turn_deg=turn_deg, robot=robot, sensors=sensors)
    with progress_bar('limits of samples') as progress:
        result = stability_lobes(
            tool,
            wanted.cut,
            tool_channels=[name.strip() for name in (tool_channels or '').split(',') if name],
            response=response,
            at=at,
            progress=progress,
            **wanted.changes,
        )
    if json:
        print_json(result.to_dict())
    else:
        show_lobes(result.found, result.name, result.poses)
    if out is not None:
        result.save(out)
        show_written(out, FILES)
    export_each(export, result.export)
