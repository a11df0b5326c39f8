"""Which option of the command line is which parameter of a node, and what only one side has.

Options and parameters come from the same schemas.  What differs stands here with the reason, and
``test/autonomous_modal_analysis/test_both_sides.py`` checks that nothing is missing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Side:
    """A node and the command that does the same with files.

    Parameters
    ----------
    command : str
        Of the command line.
    renamed : dict of str to str
        Option that a parameter of another name is.
    only_node, only_command : dict of str to str
        What the other side does without, and why.
    """

    command: str
    renamed: Mapping[str, str] = field(default_factory=dict)
    only_node: Mapping[str, str] = field(default_factory=dict)
    only_command: Mapping[str, str] = field(default_factory=dict)


TOPIC = 'names a topic; a recording is read whole, or by `--topic`'
FILE = 'says how a file without units or names is to be read; messages have them'
WRITES = 'writes a file; a node publishes, and `modal_history` keeps'
KEPT = 'goes into a history; live it is a parameter of `modal_history`'
IN_FILE = 'rarely another: in the parameter file, `--config`'
LOOP = 'of the closed loop, which needs results as they come'
ALONE = 'the command starts, waits for and ends its own player'
OF_BRIDGE = 'of the RAPID module that it writes; live that is the bridge, `rapid.*`'

SIDES = {
    'oma_identifier': Side(
        'identify',
        renamed={'topics': 'topic', 'layout_file': 'layout', 'spindle_topic': 'spindle'},
        only_node={
            'joint_states_topic': TOPIC,
            'plan_topic': TOPIC,
            'bridge_topic': TOPIC,
            'predicted_modes_topic': TOPIC,
            'base_frame': 'of messages for viewers',
            'shown_mode': 'of messages for viewers; a report shows every mode',
            'checkpoint_file': 'ids over a restart; over runs of a command `--history` keeps them',
        },
        only_command={
            'recording': 'the file',
            'others': 'loading conditions recorded one by one; live they follow in one window',
            'at': 'joint angles of a recording that has none; live they are a topic',
            'mark': 'cuts a recording to the motion; live `plan_topic` and `bridge_topic` tell it',
            'sample_rate_hz': FILE,
            'unit': FILE,
            'channels': FILE,
            'poles': 'what a person picked in the report of one recording',
            'json': WRITES,
            'out': WRITES,
            'export': WRITES,
            'history': KEPT,
            'tool': KEPT,
            'load_kg': KEPT,
            'temperature_c': KEPT,
        },
    ),
    'excitation_planner': Side(
        'plan',
        renamed={'start_pose': 'pose_deg', 'start_position': 'pose_deg'},
        only_node={
            'plan_on_start': 'a command plans once',
            'closed_loop': LOOP,
            'predicted_modes_topic': TOPIC,
            'target_frequency_std_ratio': LOOP,
            'target_damping_ratio_std_ratio': LOOP,
            'longest_window_s': LOOP,
        },
        only_command={
            'request': 'a file of these settings; a node has its parameter file',
            'serial': 'says of what angles are given; a node takes serial ones',
            'json': WRITES,
            'rapid': WRITES,
            **dict.fromkeys(
                (
                    'module_name',
                    'tool',
                    'load',
                    'work_object',
                    'mechanical_unit',
                    'udp_device',
                    'stream',
                    'collision_detection',
                    'digital_output',
                    'low_pass_hz',
                ),
                OF_BRIDGE,
            ),
        },
    ),
    'robot_bridge': Side('up', renamed={'port': 'egm_port'}),
    'abb_emulator': Side(
        'campaign --arm',
        only_node={
            'start_pose': 'a plan tells where it begins',
            'start_controller_deg': 'a plan tells where it begins',
            'sensor_address': 'no datagrams are sent: the arm is moved in the same process',
            'sensor_port': 'no datagrams are sent: the arm is moved in the same process',
            'local_address': 'no datagrams are sent: the arm is moved in the same process',
            'start_program': 'the plan is the program',
            'module': 'the plan is the program',
            'speed_ratio': 'a plan is recorded as planned',
            'automatic': 'nobody stands beside it',
            'faults': 'faults of the link, and begun while it runs: of a live cell',
            **dict.fromkeys(
                ('rws.port', 'rws.version', 'rws.address', 'rws.user', 'rws.password'),
                'no web services are asked',
            ),
        },
        only_command={'rest_s': 'recorded at rest before and after a motion; live one records'},
    ),
    'arm_state': Side('up'),
    'modal_dashboard': Side(
        'watch',
        only_node={
            'token': 'a command line is read by every user of the machine; in the parameter file',
            'host_names': IN_FILE,
            'identifier': IN_FILE,
            'planner': IN_FILE,
            'bridge': IN_FILE,
        },
        only_command={
            'config': 'the folder of the parameter file',
            'namespace': 'of every node, as ROS has it',
        },
    ),
    'modal_history': Side(
        'history alarms',
        only_node={
            'identifier': TOPIC,
            'temperature_topic': 'live; `ama identify --temperature-c` says it of a recording',
            'load_topic': 'live; `ama identify --load-kg` says it of a recording',
            'tool': 'live; `ama identify --tool` says it of a recording',
            'alarm_period_s': 'a command looks once',
        },
        only_command={
            'model': 'live it is the parameter `robot`, where that names a model',
            'acknowledge': 'live it is the service `~/acknowledge`',
            'json': 'another form of the same answer',
        },
    ),
    'modal_map': Side(
        'up',
        renamed={'map': 'map', 'cut': 'cut'},
    ),
    'replay': Side(
        'replay',
        renamed={'topics': 'topic', 'layout_file': 'layout'},
        only_node={
            'joint_names': 'those of `--robot`',
            'exit_at_end': ALONE,
            'publish_clock': ALONE,
            'start_paused': ALONE,
            'wait_for_subscribers_s': ALONE,
        },
        only_command={
            'only_play': 'without it an identifier listens, which has the options of `identify`',
        },
    ),
}


def option_of(node: str, parameter: str) -> str:
    """Return how the command line says a parameter, or why it does not, as Markdown."""
    side = SIDES[node]
    if parameter in side.only_node:
        return side.only_node[parameter]
    if side.command == 'up' and parameter not in ('robot', *side.renamed):
        return '`--parameter`'
    if side.command.endswith('--arm'):
        return f'`{parameter}`'
    return f'`--{side.renamed.get(parameter, parameter).replace("_", "-")}`'
