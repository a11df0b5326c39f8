"""Parameters of the node that answers from a map."""

from modal_core.settings.node_parameter import NodeParameter

PARAMETERS = (
    NodeParameter(
        'map',
        'file that `ama map measure` wrote; empty: nothing is predicted',
        '',
        read_only=True,
    ),
    NodeParameter(
        'robot',
        'robot of config/robots, or its folder; the map must be of it',
        'irb6660_205_190',
        read_only=True,
    ),
    NodeParameter(
        'sensors', 'sensor layout of the robot; the map must be of it', 'sensors', read_only=True
    ),
    NodeParameter(
        'cut',
        'YAML file of a cut, as `ama lobes --cut` takes it; empty: no limit of a cut is told',
        '',
        read_only=True,
    ),
    NodeParameter('joint_states_topic', 'topic of joint states', 'joint_states', read_only=True),
    NodeParameter('base_frame', 'frame named in the results', 'base_link', read_only=True),
    NodeParameter(
        'rate_hz', 'predictions while the arm moves [Hz]', 10.0, 0.1, 50.0, read_only=True
    ),
)
"""All of them."""
