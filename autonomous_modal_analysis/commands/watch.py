"""`ama watch`: the live page beside a cell that runs already."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.console.options import check_namespace, Namespace
from autonomous_modal_analysis.console.terminal import MESSAGES
from autonomous_modal_analysis.live.cell import NODES, parameter_file
from autonomous_modal_analysis.live.node_tables import checked
from autonomous_modal_analysis.live.processes import (
    all_is_stopped,
    NodeCommand,
    NodeProcesses,
    stop_event,
)

NODE = 'modal_dashboard'


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('watch')(watch)


def watch(
    config: Annotated[
        Path | None, typer.Option(help='Folder with the parameter file.', show_default='shipped')
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            min=0, max=65000, help='First port to try.', show_default='of the parameter file'
        ),
    ] = None,
    address: Annotated[
        str | None,
        typer.Option(
            help='Interface to listen on; any but 127.0.0.1 asks browsers for a token.',
            show_default='of the parameter file',
        ),
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(
            help='Robot that shapes are drawn on: of config/robots by name, or its folder.',
            show_default='of the parameter file',
        ),
    ] = None,
    namespace: Namespace = '',
) -> None:
    """Show a running cell, or what a replay finds, in the browser, until Ctrl-C.

    `ama up` serves the page by itself; this is for a cell that something else started.
    """
    from autonomous_modal_analysis.ros_ready import require_ros

    require_ros()
    stop = stop_event()
    check_namespace(namespace)
    given = {'port': port, 'address': address, 'robot': robot}
    values = {name: value for name, value in given.items() if value is not None}
    module = next(module for name, module, _ in NODES if name == NODE)
    command = NodeCommand(
        NODE, module, parameter_file(NODE, config), checked(NODE, values, 'ama watch')
    )
    with NodeProcesses((command,), namespace=namespace) as nodes:
        nodes.run_until(stop)
        MESSAGES.print('stopping')
    all_is_stopped()
