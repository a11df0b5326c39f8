"""What passed between bridge and controller, kept and played again.

In come packets and events; out go MCAP files that end well however the process ends, and from
recordings the measurements that were made.
"""

from robot_bridge.recording.packet_log import PacketLog
from robot_bridge.recording.playback import DueMessage, parse_remap, Playback

__all__ = ['DueMessage', 'PacketLog', 'Playback', 'parse_remap']
