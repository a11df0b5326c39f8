"""Parameters of the node that tells viewers of the arm."""

from modal_core.settings.node_parameter import NodeParameter

PARAMETERS = (
    NodeParameter(
        'robot', 'robot of config/robots, or its folder', 'irb6660_205_190', read_only=True
    ),
    NodeParameter('joint_states_topic', 'topic of joint states', 'joint_states', read_only=True),
    NodeParameter('rate_hz', 'how often frames are published [Hz]', 30.0, 1.0, 250.0),
)
