"""Parameters of the node that keeps results."""

from modal_core.settings.node_parameter import NodeParameter

PARAMETERS = (
    NodeParameter(
        'history', 'file that results are added to; empty: none is kept', '', read_only=True
    ),
    NodeParameter(
        'robot',
        'name, or folder, of the robot: ids are counted robot by robot; where a model of it can be'
        ' read, alarms say which part has changed',
        '',
        read_only=True,
    ),
    NodeParameter('tool', 'what the robot carries', ''),
    NodeParameter('identifier', 'node whose results are kept', 'oma_identifier', read_only=True),
    NodeParameter(
        'temperature_topic',
        'topic of sensor_msgs/Temperature; empty: not known',
        '',
        read_only=True,
    ),
    NodeParameter(
        'load_topic',
        'topic of std_msgs/Float64, the load [kg]; empty: not known',
        '',
        read_only=True,
    ),
    NodeParameter(
        'baseline_days',
        'days from the first result of a mode on in which is learnt what is usual',
        7.0,
        0.01,
        3650.0,
        read_only=True,
    ),
    NodeParameter(
        'false_a_month',
        'false alarms a month, of all modes together',
        0.1,
        1e-6,
        100.0,
        read_only=True,
    ),
    NodeParameter(
        'alarm_period_s',
        'time between two looks for changes [s]',
        600.0,
        1.0,
        86400.0,
        read_only=True,
    ),
)
"""All of them."""
