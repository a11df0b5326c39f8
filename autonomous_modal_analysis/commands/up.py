"""`ama up`: the nodes of a cell without `ros2 launch`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
import yaml

from autonomous_modal_analysis.console.options import check_namespace, Namespace
from autonomous_modal_analysis.console.terminal import MESSAGES
from autonomous_modal_analysis.live.cell import cell_commands, of_robot
from autonomous_modal_analysis.live.processes import all_is_stopped, NodeProcesses, stop_event
from modal_core.errors import SettingsError
from modal_core.files.real_path import real_path


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('up')(up)


def up(
    config: Annotated[
        Path | None, typer.Option(help='Folder with the parameter files.', show_default='shipped')
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option(help='Leave this node out (abb_emulator for a real controller).'),
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(
            help='Robot of all nodes: of config/robots by name, or its folder.',
            show_default='of the parameter files',
        ),
    ] = None,
    namespace: Namespace = '',
    egm_port: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=65535,
            help='UDP port of the bridge, and of the emulated controller: one for each cell of a'
            ' machine.',
            show_default='of the parameter files',
        ),
    ] = None,
    history: Annotated[
        Path | None, typer.Option(help='Keep every result in this history (`ama history`).')
    ] = None,
    map_path: Annotated[
        Path | None,
        typer.Option(
            '--map',
            help='Predict modes at the present pose from this file of `ama map measure`, for'
            ' viewers, the planner and the ids of the identifier.',
        ),
    ] = None,
    cut: Annotated[
        Path | None,
        typer.Option(help='With --map: tell how deep this cut may be, YAML as of `ama lobes`.'),
    ] = None,
    parameter: Annotated[
        list[str] | None,
        typer.Option(
            help='node.name=value overrides the parameter files, for example'
            ' excitation_planner.duration_s=60; may be given more than once.',
            show_default=False,
        ),
    ] = None,
    log_folder: Annotated[
        Path | None, typer.Option(help='Write one log file per node here.')
    ] = None,
) -> None:
    """Start emulator, bridge, planner, identifier and what viewers need, until Ctrl-C."""
    from autonomous_modal_analysis.ros_ready import require_ros

    require_ros()
    stop = stop_event()
    check_namespace(namespace)
    overrides = _overrides(robot, egm_port, parameter or ())
    if history is not None:
        overrides.setdefault('modal_history', {})['history'] = str(real_path(history))
    if cut is not None and map_path is None:
        raise SettingsError('a cut without a map', where='--cut', advice='add --map FILE')
    for name, path in (('map', map_path), ('cut', cut)):
        if path is not None:
            overrides.setdefault('modal_map', {})[name] = str(real_path(path))
    commands = cell_commands(config, tuple(without or ()), overrides)
    with NodeProcesses(commands, log_folder=log_folder, namespace=namespace) as nodes:
        MESSAGES.print(f'running: {", ".join(command.name for command in commands)}')
        MESSAGES.print('nothing moves until a plan is armed and started; Ctrl-C stops the nodes')
        nodes.run_until(stop)
        MESSAGES.print('stopping')
    all_is_stopped()


def _overrides(
    robot: str | None, egm_port: int | None, lines: Sequence[str]
) -> dict[str, dict[str, object]]:
    """Return the parameters that override the files, by node."""
    found = of_robot(robot) if robot is not None else {}
    if egm_port is not None:
        found.setdefault('robot_bridge', {})['port'] = egm_port
        found.setdefault('abb_emulator', {})['sensor_port'] = egm_port
    for line in lines:
        name, given, text = line.partition('=')
        # NAME:=VALUE, as ROS writes it, is meant as well.
        node, _, own_name = name.removesuffix(':').partition('.')
        try:
            value = yaml.safe_load(text)
        except yaml.YAMLError:
            value = None
        if not given or not own_name or not isinstance(value, (bool, int, float, str, list)):
            raise SettingsError(
                'not a parameter', where='--parameter', found=line, expected='node.name=value'
            )
        found.setdefault(node, {})[own_name] = value
    return found
