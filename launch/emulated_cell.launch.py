"""Start the whole cell on an emulated arm: emulator, bridge, planner and identifier."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

PACKAGE = 'autonomous_modal_analysis'
# executable, node name, parameter file
NODES = (
    ('abb_emulator', 'abb_emulator', 'emulator.yaml'),
    ('robot_bridge', 'robot_bridge', 'bridge.yaml'),
    ('excitation_planner', 'excitation_planner', 'planner.yaml'),
    ('oma_identifier', 'oma_identifier', 'identifier.yaml'),
    ('arm_state', 'arm_state', 'arm_state.yaml'),
    ('modal_dashboard', 'modal_dashboard', 'dashboard.yaml'),
    ('modal_history', 'modal_history', 'history.yaml'),
    ('modal_map', 'modal_map', 'modal_map.yaml'),
)
# They say nothing of a real arm, whatever its parameter file says.
OF_EMULATED_CELL = {'robot_bridge': {'move_emulator': True, 'emulator_link_timeout_s': 2.0}}


def generate_launch_description():
    arguments = [
        DeclareLaunchArgument('namespace', default_value='', description='Namespace of all nodes'),
        DeclareLaunchArgument(
            'use_sim_time', default_value='false', description='Take time from /clock'
        ),
        DeclareLaunchArgument(
            'log_level', default_value='info', description='debug, info, warn or error'
        ),
        DeclareLaunchArgument(
            'config',
            default_value=PathJoinSubstitution([FindPackageShare(PACKAGE), 'config']),
            description='Folder with the parameter files',
        ),
    ]
    nodes = [
        Node(
            package=PACKAGE,
            executable=executable,
            name=name,
            namespace=LaunchConfiguration('namespace'),
            parameters=[
                PathJoinSubstitution([LaunchConfiguration('config'), parameters]),
                {'use_sim_time': LaunchConfiguration('use_sim_time')},
                OF_EMULATED_CELL.get(name, {}),
            ],
            arguments=['--ros-args', '--log-level', LaunchConfiguration('log_level')],
            output='screen',
        )
        for executable, name, parameters in NODES
    ]
    return LaunchDescription(arguments + nodes)
