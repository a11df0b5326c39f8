"""The nodes of a cell and how they are started: the counterpart of the launch files."""

from collections.abc import Mapping
from pathlib import Path

from autonomous_modal_analysis.live.node_tables import check_file, checked
from autonomous_modal_analysis.live.processes import NodeCommand
from modal_core.errors import SettingsError
from modal_core.files.share import share_path
from modal_core.settings.near_names import refuse_unknown

# node name, module, parameter file; the order is the order they start in
NODES = (
    ('abb_emulator', 'abb_emulator.node.emulator_node', 'emulator.yaml'),
    ('robot_bridge', 'robot_bridge.node.bridge_node', 'bridge.yaml'),
    ('excitation_planner', 'excitation_planner.node.planner_node', 'planner.yaml'),
    ('oma_identifier', 'oma_identifier.node.identifier_node', 'identifier.yaml'),
    ('arm_state', 'robot_bridge.node.arm_state_node', 'arm_state.yaml'),
    ('modal_dashboard', 'modal_dashboard.dashboard_node', 'dashboard.yaml'),
    ('modal_history', 'modal_history.history_node', 'history.yaml'),
    ('modal_map', 'workspace_map.node.map_node', 'modal_map.yaml'),
)
# Left out where a folder of parameter files has none for them: they must not show another robot.
FOR_VIEWERS = ('arm_state', 'modal_dashboard')
# Left out where nothing names the file that each keeps results in, or answers from.
FILES = {'modal_history': 'history', 'modal_map': 'map'}
# Of a bridge beside an emulator; they say nothing of a real arm, whatever its parameter file says.
BESIDE_EMULATOR = {'move_emulator': True, 'emulator_link_timeout_s': 2.0}


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
    if config is not None:
        files = {name: file for name, _, file in NODES}
        lacking = (name for name in FOR_VIEWERS if not (config / files[name]).is_file())
        without = (*without, *lacking)
    given = dict(parameters or {})
    without = (*without, *_nameless(config, given))
    if 'abb_emulator' not in without:
        given['robot_bridge'] = _beside_emulator(given.get('robot_bridge', {}))
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


def _nameless(config: Path | None, given: Mapping[str, Mapping[str, object]]) -> tuple[str, ...]:
    """Return the nodes whose file nobody names: neither a parameter nor a file of parameters."""
    files = {name: file for name, _, file in NODES}
    return tuple(
        name
        for name, parameter in FILES.items()
        if not given.get(name, {}).get(parameter)
        and not (config is not None and (config / files[name]).is_file())
    )


def of_robot(robot: str) -> dict[str, dict[str, object]]:
    """Return the parameters, by node, of a cell with another robot.

    Parameters
    ----------
    robot : str
        Of config/robots by name, or its folder.

    Raises
    ------
    ModelError
        There is none.
    """
    # With the library of rigid bodies, some 50 MB.
    from modal_core.channel import LAYOUT_FILE
    from structural_model.robot_files import robot_folder

    folder = robot_folder(robot).resolve()
    found: dict[str, dict[str, object]] = {
        name: {'robot': str(folder)}
        for name in ('abb_emulator', 'robot_bridge', 'excitation_planner', *FOR_VIEWERS, *FILES)
    }
    return {**found, 'oma_identifier': {'layout_file': str(folder / LAYOUT_FILE)}}


def _beside_emulator(values: Mapping[str, object]) -> Mapping[str, object]:
    """Return the bridge's parameters in a cell with an emulator; a dry run asked for stays one."""
    if 'dry_run' in values:
        return {**BESIDE_EMULATOR, 'move_emulator': False, **values}
    return {**BESIDE_EMULATOR, **values}


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
