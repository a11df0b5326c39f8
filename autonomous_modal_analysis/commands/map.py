"""`ama map`: modes and tool-point response of a robot at every pose, from a few measured ones."""

import math
from pathlib import Path
from typing import Annotated, Any, TYPE_CHECKING

import typer

from autonomous_modal_analysis.console.options import (
    check_namespace,
    Export,
    Json,
    Namespace,
    POSE_HELP,
    Serial,
)
from modal_core.errors import SettingsError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from autonomous_modal_analysis.mapping import MapWish, Series
    from modal_core.channel import SensorLayout
    from modal_core.mode import ModeSet
    from structural_model import FlexibleJointModel
    from workspace_map import ToolPoint

Robot = Annotated[str, typer.Option(help='Robot of config/robots, its folder, or its model.yaml.')]
Sensors = Annotated[str, typer.Option(help='Sensor layout of the robot.')]
MapPath = Annotated[
    Path, typer.Option('--map', help='File that `ama map measure` wrote.', show_default=False)
]
Tool = Annotated[
    str | None,
    typer.Option(
        help='Tool point: a link, or link:x,y,z \\[m] in its frame.',
        show_default='the last link',
    ),
]


def register(app: typer.Typer) -> None:
    """Add the command and its own."""
    group = typer.Typer(
        help='Modes and tool-point response at every pose, from a few measured ones.',
        no_args_is_help=True,
    )
    for command in (measure, predict, report):
        group.command(command.__name__)(command)
    app.add_typer(group, name='map')


def measure(
    robot: Robot = 'irb6660_205_190',
    out: Annotated[Path, typer.Option(help='Folder for map.json and recordings.')] = Path('map'),
    poses: Annotated[int, typer.Option(help='Poses to measure at most.')] = 12,
    accuracy_percent: Annotated[
        float, typer.Option(help='σ over value that 90 % of all frequencies shall have.')
    ] = 0.5,
    budget_s: Annotated[float, typer.Option(help='Time of the arm, motion and records.')] = 1200.0,
    record_s: Annotated[
        float | None,
        typer.Option(help='Length of each record.', show_default='what the accuracy needs'),
    ] = None,
    highest_hz: Annotated[float, typer.Option(help='Modes below it are mapped.')] = 60.0,
    seed: Annotated[int, typer.Option(help='Of poses and motions.')] = 1,
    tool: Tool = None,
    sensors: Sensors = 'sensors',
    arm: Annotated[
        Path | None, typer.Option(help='YAML file with what the emulated arm has: effects, ...')
    ] = None,
    transfer: Annotated[
        Path | None,
        typer.Option(help='map.json of another arm of this kind, or tool, to begin with.'),
    ] = None,
    release: Annotated[
        str | None,
        typer.Option(
            help='Hash of the series of motions, as shown without this option: releases them all.'
        ),
    ] = None,
    live: Annotated[
        bool,
        typer.Option(
            '--live',
            help='On the robot at the bridge of this ROS domain: its motions run while the SPACE'
            ' bar is held.',
        ),
    ] = False,
    namespace: Namespace = '',
    joy: Annotated[
        bool,
        typer.Option('--joy', help='With --live: hold a button of a joystick, not a key.'),
    ] = False,
    joy_topic: Annotated[str, typer.Option(help='Topic of the joystick.')] = 'joy',
    button: Annotated[int, typer.Option(min=0, help='Number of its deadman button.')] = 4,
) -> None:
    """Measure a map: poses, ways and motions are chosen and checked before the first.

    On the emulated arm, or with --live on the robot. Without --release the series is shown with
    its hash and nothing moves. The map is written after every pose; given again, the command goes
    on where it stopped.
    """
    from dataclasses import replace

    from abb_emulator.run_plan import ArmOptions
    from autonomous_modal_analysis.campaigns.emulated_player import EmulatedPlayer
    from autonomous_modal_analysis.console.terminal import MESSAGES, OUTPUT, progress_bar
    from autonomous_modal_analysis.mapping import (
        MappingFolder,
        MapWish,
        plan_series,
    )
    from autonomous_modal_analysis.mapping import measure as measure_series
    from modal_core.files.yaml_file import load_yaml
    from structural_model import load_layout, load_robot
    from workspace_map import Arm, load_other_map, WorkspaceMap

    check_namespace(namespace)
    if (namespace or joy) and not live:
        raise SettingsError(
            'the emulated arm is in no ROS domain', where='--namespace, --joy', advice='add --live'
        )
    if arm is not None and live:
        raise SettingsError('of an emulated arm', where='--arm', advice='leave it out')
    wish = MapWish(
        poses=poses,
        accuracy=accuracy_percent / 100.0,
        budget_s=budget_s,
        record_s=record_s,
        highest_hz=highest_hz,
        seed=seed,
    )

    def tell(text: str) -> None:
        MESSAGES.print(text, soft_wrap=True, markup=False)

    options = ArmOptions.from_mapping(load_yaml(arm) if arm else {})
    model, layout = load_robot(robot), load_layout(robot, sensors)
    point = tool_point(model, tool)
    other = load_other_map(transfer, model, layout) if transfer else None
    start = WorkspaceMap(Arm(model, layout.channels, point), highest_hz, before=other)
    if not start.same_tool:
        tell(f'{transfer} is of another tool: what it found of the payload is not taken over')
    folder = MappingFolder(out, layout)
    series = folder.series(start, wish)
    if series is None:
        with progress_bar('planning the series') as progress:
            series = plan_series(model, layout, start, wish, progress)
        folder.keep(series)
    if release is None:
        _preview(series, model)
        return
    if release != series.series_hash:
        raise SettingsError(
            'not the hash of this series', where='--release', found=release,
            expected=series.series_hash, advice='look at the series without --release',
        )  # fmt: skip

    if live:
        deadman = (joy_topic if joy else '', button)
        with _at_the_robot(series, wish, robot, layout, namespace, *deadman) as at:
            found = measure_series(folder, start, series, wish, at.play, tell, travel=at.travel)
    else:
        player = EmulatedPlayer(replace(options, robot=robot, sensors_file=sensors))
        found = measure_series(folder, start, series, wish, player.play, tell)
    OUTPUT.print(f'written: {folder.map_path}, {len(found.measured)} poses', markup=False)
    if other is not None and found.worth_of_transfer() < 0.0:
        tell(f'{transfer} does not fit this arm: the model alone explains it better')


def _at_the_robot(
    series: 'Series',
    wish: 'MapWish',
    robot: str,
    layout: 'SensorLayout',
    namespace: str,
    joy_topic: str,
    button: int,
) -> 'AbstractContextManager[Any]':
    """Return, as a context manager, who plays a released series at the bridge."""
    from autonomous_modal_analysis.ros_ready import require_ros

    require_ros()
    from autonomous_modal_analysis.mapping import request_of
    from autonomous_modal_analysis.mapping.live_series_node import Deadman, live_series
    from autonomous_modal_analysis.operating.keyboard import check_terminal
    from autonomous_modal_analysis.operating.terminal_person import TerminalPerson
    from structural_model import load_robot

    if not joy_topic:
        check_terminal()
    request = request_of(wish, series.duration_s)
    person, deadman = TerminalPerson(robot), Deadman(joy_topic, button)
    made: AbstractContextManager[Any] = live_series(
        load_robot(robot), request, series, person, deadman, namespace, layout
    )
    return made


def predict(
    map_path: MapPath,
    pose_deg: Annotated[str, typer.Option(help=f'Where. {POSE_HELP}', show_default=False)],
    serial: Serial = False,
    robot: Robot = 'irb6660_205_190',
    sensors: Sensors = 'sensors',
    tool: Tool = None,
    export: Export = None,
    json: Json = False,
) -> None:
    """Predict the modes at a pose, measured or not, with their standard deviations.

    Refused where the map does not know: too far from every measured pose. --export has the
    shapes at the sensors; modal masses at the tool are in --json.
    """
    from autonomous_modal_analysis.console.terminal import print_json
    from autonomous_modal_analysis.export import check_endings, ENDINGS, export_arm_modes
    from autonomous_modal_analysis.pose import parse_pose
    from autonomous_modal_analysis.views.output import export_each
    from modal_core.files.version import software
    from structural_model import load_layout, load_robot
    from workspace_map import load_map

    check_endings(export or (), ENDINGS)
    model, layout = load_robot(robot), load_layout(robot, sensors)
    known, _ = load_map(map_path, model, layout, tool_point(model, tool) if tool else None)
    found = known.predict_surely(parse_pose(model, pose_deg, serial))
    if json:
        print_json(predicted_content(model, known.arm.tool, found))
    else:
        _show(found)
    about = {'map': map_path.name, 'software': software()}
    export_each(
        export,
        lambda file: export_arm_modes(
            file, model, layout, found.q, predicted_modes(found, layout), about
        ),
    )


def predicted_modes(found: Any, layout: 'SensorLayout') -> 'ModeSet':
    """Return predicted modes as others are, the largest entry of each shape 1."""
    from modal_core.mode import Mode, ModeSet
    from modal_core.numbers.indicators import normalise

    return ModeSet(
        tuple(
            Mode(
                float(found.frequency_hz[number]),
                float(found.damping_ratio[number]),
                normalise(shape.astype(complex)),
                frequency_std_hz=float(found.frequency_std_hz[number]),
                damping_ratio_std=float(found.damping_ratio_std[number]),
            )
            for number, shape in enumerate(found.channel_shapes.T)
        ),
        tuple(channel.name for channel in layout.channels),
    )


def report(
    map_path: MapPath,
    out: Annotated[Path, typer.Option(help='HTML file.')] = Path('map.html'),
    pose_deg: Annotated[
        str | None,
        typer.Option(
            help=f'What the other joints are at. {POSE_HELP}', show_default='first named'
        ),
    ] = None,
    serial: Serial = False,
    axes: Annotated[
        str, typer.Option(help='Two controller axes that are varied, as 2,3.')
    ] = '2,3',
    robot: Robot = 'irb6660_205_190',
    sensors: Sensors = 'sensors',
) -> None:
    """Draw a map: frequencies and their deviations over two axes, and the measured poses."""
    from autonomous_modal_analysis.console.options import numbers
    from autonomous_modal_analysis.console.terminal import OUTPUT
    from autonomous_modal_analysis.map_report import render_map
    from autonomous_modal_analysis.pose import parse_pose
    from modal_core.files.atomic_file import write_text
    from structural_model import load_layout, load_robot
    from workspace_map import load_map

    model, layout = load_robot(robot), load_layout(robot, sensors)
    known, _ = load_map(map_path, model, layout)
    places = tuple(int(number) - 1 for number in numbers(axes, 'axes'))
    if len(set(places)) != 2 or not set(places) <= set(range(model.n_joints)):
        raise SettingsError(
            'not two axes', where='--axes', found=axes, expected=f'two of 1 to {model.n_joints}'
        )
    pose = parse_pose(model, pose_deg, serial)
    write_text(out, render_map(known, pose, (places[0], places[1])))
    OUTPUT.print(f'written: {out}', markup=False)


def tool_point(model: 'FlexibleJointModel', text: str | None) -> 'ToolPoint':
    """Return the tool point a person names.

    Raises
    ------
    SettingsError
        No such link, or not three numbers.
    """
    from workspace_map import ToolPoint

    link, _, place = (text or model.link_names[-1]).partition(':')
    if link not in model.link_names:
        raise SettingsError(
            'unknown link', where='--tool', found=link, expected=', '.join(model.link_names)
        )
    try:
        x, y, z = (float(part) for part in place.split(',')) if place else (0.0, 0.0, 0.0)
    except ValueError:
        x = y = z = math.nan
    if not math.isfinite(x + y + z):
        raise SettingsError(
            'not three numbers', where='--tool', found=place, expected='link:x,y,z'
        )
    return ToolPoint(link, (x, y, z))


def predicted_content(
    model: 'FlexibleJointModel', tool: 'ToolPoint', found: Any
) -> dict[str, Any]:
    """Return predicted modes as `ama lobes` reads them, SI units.

    The modal mass along a shape is 1 / |shape|²; the covariance is of log frequency, log damping
    ratio and shape of the first mode, of the second, ...
    """
    import numpy as np

    from workspace_map import tool_modes

    columns = {
        'frequency_hz': found.frequency_hz,
        'frequency_std_hz': found.frequency_std_hz,
        'damping_ratio': found.damping_ratio,
        'damping_ratio_std': found.damping_ratio_std,
        'shape': found.tool_shapes.T,
        'shape_std': found.tool_shape_std.T,
    }
    modes = [
        {name: np.asarray(part[number]).tolist() for name, part in columns.items()}
        for number in range(len(found))
    ]
    return {
        'frame': f'{model.robot_name}, {tool.link} at {tool.position_m} m',
        'pose_deg': model.shown_axes(found.q).tolist(),
        'modes': modes,
        'covariance': np.asarray(tool_modes(found).covariance).tolist(),
    }


def _show(found: Any) -> None:
    from rich.table import Table

    from autonomous_modal_analysis.console.terminal import OUTPUT
    from modal_reports import with_sigma

    table = Table()
    for name in ('frequency / Hz', 'damping / %', 'modal mass at the tool / kg'):
        table.add_column(name, justify='right')
    columns = (
        (found.frequency_hz, found.frequency_std_hz),
        (100.0 * found.damping_ratio, 100.0 * found.damping_ratio_std),
        (found.modal_mass_kg, found.modal_mass_std_kg),
    )
    for number in range(len(found)):
        table.add_row(*(with_sigma(value[number], std[number]) for value, std in columns))
    OUTPUT.print(table)


def _preview(series: 'Series', model: 'FlexibleJointModel') -> None:

    from autonomous_modal_analysis.console.terminal import OUTPUT

    for number, stop in enumerate(series.stops):
        axes = model.axes_words(stop.pose_rad)
        way = f'{stop.way_s:.0f} s there, ' if stop.way_s else ''
        line = f'{number + 1:2d}: axes at {axes}; {way}{stop.record_s:.0f} s'
        OUTPUT.print(line, soft_wrap=True, markup=False)
    OUTPUT.print(f'{len(series.stops)} poses, {series.seconds / 60.0:.1f} min of the arm')
    OUTPUT.print(f'to release: --release {series.series_hash}', soft_wrap=True, markup=False)
