"""`ama campaign`: record the robot at several poses and amplitudes, for `ama gap`."""

from pathlib import Path
from typing import Annotated, Any, TYPE_CHECKING

import typer

from autonomous_modal_analysis.console.option_groups import grouped, Wish
from autonomous_modal_analysis.console.options import (
    check_namespace,
    Effects,
    ExportTable,
    Namespace,
    POSE_HELP,
    Serial,
)
from modal_core.errors import SettingsError

# Of poses that are looked at for one more recording.
MOST_ASKED = 4

if TYPE_CHECKING:
    from collections.abc import Sequence
    from contextlib import AbstractContextManager

    from autonomous_modal_analysis.campaigns.campaign_plan import CampaignWish
    from modal_core.channel import SensorLayout
    from structural_model.flexible_joint_model import FlexibleJointModel


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('campaign')(grouped(campaign))


def campaign(
    wish: Wish,
    robot: Annotated[
        str, typer.Argument(help='Robot of config/robots, its folder, or its model.yaml.')
    ] = 'irb6660_205_190',
    out: Annotated[Path, typer.Option(help='Folder for recordings and campaign.yaml.')] = Path(
        'campaign'
    ),
    poses: Annotated[int, typer.Option(help='How many poses are chosen.')] = 9,
    pose_deg: Annotated[
        list[str] | None,
        typer.Option(help=f'Record at this pose; may be given more than once. {POSE_HELP}'),
    ] = None,
    serial: Serial = False,
    levels: Annotated[
        str, typer.Option(help='Amplitudes, parts of the full one, separated by commas.')
    ] = '1,0.35',
    states: Annotated[
        str,
        typer.Option(
            help='Instead of levels: standing (joints stuck), running (joints slide on sweeps), or'
            ' both, separated by a comma; `ama compare` tells what differs.'
        ),
    ] = '',
    sensors: Annotated[str, typer.Option(help='Sensor layout of the robot.')] = 'sensors',
    arm: Annotated[
        Path | None,
        typer.Option(
            help='YAML file with what the emulated arm has: effects, tolerance, sensors, ...'
        ),
    ] = None,
    live: Annotated[
        bool,
        typer.Option(
            '--live',
            help='Record on the robot in this ROS domain: each motion waits until a person has'
            ' released and started it at the bridge.',
        ),
    ] = False,
    namespace: Namespace = '',
    dry_run: Annotated[
        bool, typer.Option('--dry-run', help='Choose and check all motions; record nothing.')
    ] = False,
    following: Annotated[
        Path | None,
        typer.Option(
            '--next',
            help='Folder of recordings: say what they can tell apart, and which one more would'
            ' add most; record nothing.',
        ),
    ] = None,
    effects: Effects = None,
    export: ExportTable = None,
) -> None:
    """Record a campaign: poses far apart, times amplitude levels.

    On the emulated arm, or with --live on the robot, which this command never moves. Every motion
    is planned and checked against all limits before the first one is played. A campaign that was
    interrupted goes on where it stopped when the command is given again.
    """
    from contextlib import nullcontext
    from dataclasses import replace

    from abb_emulator.run_plan import ArmOptions
    from autonomous_modal_analysis.campaigns.campaign_plan import (
        CampaignWish,
        check_all,
        DEFAULTS,
        planned_recordings,
        planned_table,
        STATE_DEFAULTS,
    )
    from autonomous_modal_analysis.campaigns.campaign_recording import (
        CampaignFolder,
        record_campaign,
    )
    from autonomous_modal_analysis.campaigns.emulated_player import EmulatedPlayer
    from autonomous_modal_analysis.console.options import numbers
    from autonomous_modal_analysis.console.terminal import MESSAGES, OUTPUT, progress_bar
    from autonomous_modal_analysis.export import check_endings, TABLE_ENDINGS
    from autonomous_modal_analysis.pose import parse_pose
    from modal_core.files.yaml_file import load_yaml
    from structural_model.robot_files import load_layout, load_robot

    check_namespace(namespace)
    check_endings(export or (), TABLE_ENDINGS)
    if export and following:
        raise SettingsError('nothing is recorded', where='--export', found='--next')
    if namespace and not live:
        raise SettingsError(
            'the emulated arm is in no ROS domain', where='--namespace', advice='add --live'
        )
    model, layout = load_robot(robot), load_layout(robot, sensors)
    options = ArmOptions.from_mapping(load_yaml(arm) if arm else {})
    asked_states = tuple(part.strip() for part in states.split(',') if part.strip())
    asked = CampaignWish(
        poses=[parse_pose(model, text, serial) for text in pose_deg or ()],
        n_poses=poses,
        levels=numbers(levels, 'levels'),
        states=asked_states,
        request=wish.plan_request(**(STATE_DEFAULTS if asked_states else DEFAULTS)),
    )
    if following:
        _tell_next(following, robot, asked, effects or ())
        return
    if effects:
        raise SettingsError(
            'effects take no part in recording', where='--effects', advice='add --next'
        )
    planned = planned_recordings(model, layout, asked)
    with progress_bar('checking the motions') as progress:
        check_all(model, layout, planned, progress)
    if dry_run:
        for item in planned:
            OUTPUT.print(item.words(model), soft_wrap=True, markup=False)
        _export(export or (), planned_table(model, planned))
        return
    with (
        _at_the_robot(model, layout, namespace)
        if live
        else nullcontext(EmulatedPlayer(replace(options, robot=robot, sensors_file=sensors)))
    ) as player:
        folder = CampaignFolder(out, model, layout, player.options, (player.note,))
        with progress_bar(f'recording {len(planned)} motions') as progress:
            record_campaign(folder, planned, player.play, progress, MESSAGES.print)
    _export(export or (), planned_table(model, planned))
    OUTPUT.print(f'written: {out}/campaign.yaml and {len(planned)} recordings', markup=False)
    if len(asked_states) > 1:
        files = ' '.join(str(out / f'pose_01_{state}.mcap') for state in asked_states)
        OUTPUT.print(f'next: ama compare {files} --robot {robot}', soft_wrap=True, markup=False)
    else:
        OUTPUT.print(f'next: ama gap {out} --model {robot}', markup=False)


def _export(files: 'Sequence[Path]', columns: dict[str, list[object]]) -> None:
    """Write what is recorded, a row a recording."""
    from autonomous_modal_analysis.export import export_table, Table
    from autonomous_modal_analysis.views.output import export_each
    from modal_core.files.version import software

    table = Table.of(columns, {'software': software()})
    export_each(files, lambda file: export_table(file, table))


def _tell_next(folder: Path, robot: str, asked: 'CampaignWish', effects: 'Sequence[Path]') -> None:
    """Say what recordings can tell apart, and what one more would add."""
    from autonomous_modal_analysis.api.gap import campaign_of
    from autonomous_modal_analysis.campaigns.campaign_poses import choose_poses
    from autonomous_modal_analysis.console.terminal import OUTPUT, progress_bar
    from model_gap.report import telling_lines
    from model_gap.stated import stated_settings
    from model_gap.telling import what_it_tells
    from structural_model.robot_files import load_robot

    model = load_robot(robot)
    with progress_bar(f'reading {folder.name}') as progress:
        data = campaign_of(folder, robot, None, progress)
    settings = stated_settings(model, data, effects=effects)
    poses = list(asked.poses) or choose_poses(
        model, data.layout, min(asked.n_poses, MOST_ASKED), asked.request
    )
    with progress_bar('predicting every effect') as progress:
        found = what_it_tells(model, data, poses, settings, progress)
    for line in telling_lines(found, model):
        OUTPUT.print(line, soft_wrap=True, markup=False)


def _at_the_robot(
    model: 'FlexibleJointModel', layout: 'SensorLayout', namespace: str
) -> 'AbstractContextManager[Any]':
    from autonomous_modal_analysis.ros_ready import require_ros

    require_ros()
    from autonomous_modal_analysis.console.terminal import MESSAGES
    from autonomous_modal_analysis.live.live_player_node import live_player

    def tell(text: str) -> None:
        MESSAGES.print(text, soft_wrap=True, markup=False)

    player: AbstractContextManager[Any] = live_player(model, tell, namespace, layout)
    return player
