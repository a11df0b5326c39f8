"""The nodes' executables: where ROS or its messages are missing, one line says what to install."""

from contextlib import suppress
from importlib import import_module
import sys
from typing import NoReturn

from autonomous_modal_analysis.missing import EXIT_MISSING, explain, MissingError
from modal_core.work.quiet_loading import quiet_loading

NODES = {
    'abb_emulator': 'abb_emulator.node.emulator_node',
    'arm_state': 'robot_bridge.node.arm_state_node',
    'excitation_planner': 'excitation_planner.node.planner_node',
    'modal_dashboard': 'modal_dashboard.dashboard_node',
    'modal_history': 'modal_history.history_node',
    'modal_map': 'workspace_map.node.map_node',
    'oma_identifier': 'oma_identifier.node.identifier_node',
    'replay': 'robot_bridge.node.replay_node',
    'robot_bridge': 'robot_bridge.node.bridge_node',
}


def abb_emulator() -> None:
    """Run the emulated controller and arm."""
    _run('abb_emulator')


def arm_state() -> None:
    """Tell viewers of the arm."""
    _run('arm_state')


def excitation_planner() -> None:
    """Run the planner."""
    _run('excitation_planner')


def modal_dashboard() -> None:
    """Serve the live page."""
    _run('modal_dashboard')


def modal_history() -> None:
    """Keep results."""
    _run('modal_history')


def modal_map() -> None:
    """Answer from a map."""
    _run('modal_map')


def oma_identifier() -> None:
    """Run the identifier."""
    _run('oma_identifier')


def replay() -> None:
    """Play a recording."""
    _run('replay')


def robot_bridge() -> None:
    """Run the bridge to the controller."""
    _run('robot_bridge')


def _run(name: str) -> None:
    try:
        with quiet_loading():
            from autonomous_modal_analysis.ros_ready import require_ros

            require_ros()
            node = import_module(NODES[name])
    except ImportError as error:
        missing = explain(error)
        if missing is None:
            raise
        _refuse(name, missing)
    except MissingError as error:
        _refuse(name, error)
    with suppress(KeyboardInterrupt):
        node.main()


def _refuse(name: str, error: MissingError) -> NoReturn:
    sys.stderr.write(f'{name}: {error}\n')
    sys.exit(EXIT_MISSING)
