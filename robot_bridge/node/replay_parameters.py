"""Parameters of the replay node: names, meaning, ranges."""

from dataclasses import replace

from modal_core.settings.node_parameter import NodeParameter, parameters_of
from robot_bridge.playback_settings import PlaybackSettings

PARAMETERS = tuple(
    replace(item, read_only=True)
    for item in (
        NodeParameter('recording', 'rosbag2 folder, .mcap, .db3, .bag, .npy or .csv', ''),
        NodeParameter('topics', 'play only these topics; empty: every usable one', ('',)),
        NodeParameter('remap', 'old:=new, one entry per topic', ('',)),
        *parameters_of(PlaybackSettings),
        NodeParameter('publish_clock', 'publish /clock in recorded time', False),
        NodeParameter('start_paused', 'wait for ~/pause false or ~/step', False),
        NodeParameter(
            'wait_for_subscribers_s',
            'longest wait until every topic is listened to',
            10.0,
            0.0,
            86400.0,
        ),
        NodeParameter('exit_at_end', 'end the process when everything is played', True),
        NodeParameter(
            'sample_rate_hz', 'plain arrays: rate [Hz]; 0: from the sidecar file', 0.0, 0.0, 1e7
        ),
        NodeParameter('unit', 'plain arrays: unit; empty: from the sidecar file', ''),
        NodeParameter(
            'channels', 'plain arrays: names of the columns; empty: from the sidecar file', ('',)
        ),
        NodeParameter(
            'joint_names',
            'plain arrays: joints of the robot in its order, whose columns are joint states',
            ('',),
        ),
        NodeParameter(
            'layout_file', 'plain arrays: sensor layout whose names its channels take', ''
        ),
    )
)
