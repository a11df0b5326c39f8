"""`ama up`: the nodes of a cell without `ros2 launch`."""

from pathlib import Path
import re
import signal
import threading
from typing import Annotated

import typer

from autonomous_modal_analysis.cell import cell_commands
from autonomous_modal_analysis.processes import NodeProcesses
from autonomous_modal_analysis.terminal import MESSAGES
from modal_core.errors import SettingsError
from modal_core.missing import require_ros

CHECK_EVERY_S = 0.5


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
    namespace: Annotated[str, typer.Option(help='ROS namespace of all nodes.')] = '',
    log_folder: Annotated[
        Path | None, typer.Option(help='Write one log file per node here.')
    ] = None,
) -> None:
    """Start emulator, bridge, planner and identifier, one process each, until Ctrl-C."""
    require_ros()
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    if not re.fullmatch(r'/?([A-Za-z_]\w*(/[A-Za-z_]\w*)*/?)?', namespace, re.ASCII):
        raise SettingsError(
            'not a ROS namespace',
            where='--namespace',
            found=namespace,
            expected='letters, digits and _, parts separated by /',
        )
    commands = cell_commands(config, tuple(without or ()))
    with NodeProcesses(commands, log_folder=log_folder, namespace=namespace) as nodes:
        MESSAGES.print(f'running: {", ".join(command.name for command in commands)}')
        MESSAGES.print('nothing moves until a plan is armed and started; Ctrl-C stops the nodes')
        while not stop.wait(CHECK_EVERY_S):
            nodes.check()
        MESSAGES.print('stopping')
