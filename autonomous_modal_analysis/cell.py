"""The nodes of a cell and how they are started: the counterpart of the launch files."""

from collections.abc import Mapping
from pathlib import Path

from autonomous_modal_analysis.node_tables import check_file, checked
from autonomous_modal_analysis.processes import NodeCommand
from modal_core.errors import SettingsError
from modal_core.near_names import refuse_unknown
from modal_core.share import share_path

# node name, module, parameter file; the order is the order they start in
NODES = (
    ('abb_emulator', 'abb_emulator.node.emulator_node', 'emulator.yaml'),
    ('robot_bridge', 'robot_bridge.node.bridge_node', 'bridge.yaml'),
    ('excitation_planner', 'excitation_planner.planner_node', 'planner.yaml'),
    ('oma_identifier', 'oma_identifier.node.identifier_node', 'identifier.yaml'),
)


def cell_commands(
    config: Path | None = None,
    without: tuple[str, ...] = (),
    parameters: Mapping[str, Mapping[str, object]] | None = None,
) -> tuple[NodeCommand, ...]:
    """Return how to start the nodes of a cell.

    Parameters
    ----------
    config : Path or None
        Folder with the parameter files; None takes the ones shipped.
    without : tuple of str
        Nodes to leave out.
    parameters : mapping of node name to parameters
        Overrides of the files.

    Raises
    ------
    SettingsError
        An unknown node or parameter, or a parameter file that is not there.
    """
    names = tuple(name for name, _, _ in NODES)
    given = parameters or {}
    refuse_unknown((*without, *given), names, 'unknown node')
    made = {name: checked(name, values, f'node {name}') for name, values in given.items()}
    commands = tuple(
        NodeCommand(name, module, parameter_file(name, config), made.get(name, {}))
        for name, module, _ in NODES
        if name not in without
    )
    for command in commands:
        check_file(command.name, parameter_file(command.name, config))
    return commands


def parameter_file(name: str, config: Path | None = None) -> Path:
    """Return the parameter file of a node.

    Parameters
    ----------
    name : str
        Node name.
    config : Path or None
        Folder with the parameter files; None takes the ones shipped.

    Raises
    ------
    SettingsError
        It is not there.
    """
    folder = config if config is not None else share_path('config')
    path = folder / next(file for node, _, file in NODES if node == name)
    if not path.is_file():
        raise SettingsError('parameter file missing', where=path, advice=f'needed by {name}')
    return path
