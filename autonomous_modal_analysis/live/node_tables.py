"""The parameters of each node, and the check of what it is given before it starts; no ROS."""

from collections.abc import Iterator, Mapping
import importlib
from pathlib import Path
from typing import Any

from modal_core.errors import SettingsError
from modal_core.files.yaml_file import load_yaml
from modal_core.settings.near_names import refuse_unknown
from modal_core.settings.node_parameter import checked_parameters, is_of_ros, NodeParameter

TABLES = {
    'oma_identifier': 'oma_identifier.node.node_parameters',
    'excitation_planner': 'excitation_planner.node.planner_parameters',
    'robot_bridge': 'robot_bridge.bridge_settings',
    'abb_emulator': 'abb_emulator.node.emulator_parameters',
    'arm_state': 'robot_bridge.node.arm_state_parameters',
    'modal_dashboard': 'modal_dashboard.node_parameters',
    'modal_history': 'modal_history.node_parameters',
    'modal_map': 'workspace_map.node.node_parameters',
    'replay': 'robot_bridge.node.replay_parameters',
}
EVERY = ('*', '**')
VALUES = 'ros__parameters'


def parameters_of_node(name: str) -> tuple[NodeParameter, ...]:
    """Return all parameters that a node declares."""
    found: tuple[NodeParameter, ...] = importlib.import_module(TABLES[name]).PARAMETERS
    return found


def checked(name: str, values: Mapping[str, Any], where: object) -> dict[str, Any]:
    """Return a node's parameters in its own types.

    Raises
    ------
    SettingsError
        The node has no such parameter, or it is of another type or out of range.
    """
    return checked_parameters(parameters_of_node(name), values, where)


def check_file(name: str, path: Path) -> None:
    """Refuse a parameter file that a node would not take as it is meant.

    Raises
    ------
    SettingsError
        It is for other nodes, or names a parameter that the node has not.
    """
    known = [item.name for item in parameters_of_node(name)]
    for nodes, values in _sections(load_yaml(path), path):
        node = nodes.rpartition('/')[2]
        refuse_unknown([node], (*TABLES, *EVERY), 'unknown node', path)
        if node in (name, *EVERY):
            names = (key for key in _names(values) if not is_of_ros(key))
            refuse_unknown(names, known, 'unknown parameter', f'{path}: {nodes}')


def _sections(data: Mapping[str, Any], path: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the nodes and the parameters of each section; namespaces may stand around a node."""
    for key, value in data.items():
        if not isinstance(value, Mapping):
            raise SettingsError(
                'no parameters of a node', where=path, found=key, expected='a node, or /**'
            )
        if VALUES in value:
            values = value[VALUES] or {}
            if not isinstance(values, Mapping):
                raise SettingsError(
                    'no parameters of a node', where=f'{path}: {key}.{VALUES}', found=values
                )
            yield str(key), values
        else:
            yield from _sections(value, path)


def _names(values: Mapping[str, Any], prefix: str = '') -> Iterator[str]:
    """Yield the parameters by full name: groups are nested in a file."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _names(value, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}'
