"""Parameters of the node that serves the page."""

from modal_core.settings.node_parameter import NodeParameter

PARAMETERS = (
    NodeParameter(
        'address',
        'interface to listen on; any but the loopback asks for the token',
        '127.0.0.1',
        read_only=True,
    ),
    NodeParameter(
        'port',
        'TCP port of the page; where it is taken one of the next twenty; 0: any that is free',
        8470,
        0,
        65000,
        read_only=True,
    ),
    NodeParameter(
        'token',
        'what a browser shows when it is not on this machine; empty: made anew at every start',
        '',
        read_only=True,
    ),
    NodeParameter(
        'host_names',
        'names by which browsers ask for the page, beside localhost and the name of the machine',
        (),
        read_only=True,
        kind=str,
    ),
    NodeParameter(
        'robot',
        'robot of config/robots, or its folder, that shapes are drawn on; empty: on none',
        'irb6660_205_190',
        read_only=True,
    ),
    NodeParameter('identifier', 'node whose results are shown', 'oma_identifier', read_only=True),
    NodeParameter('planner', 'node whose plans are shown', 'excitation_planner', read_only=True),
    NodeParameter('bridge', 'node whose state is shown', 'robot_bridge', read_only=True),
)
"""All of them."""
