"""Another tool on the same machine: in come receptances of both; out goes that of the tip."""

from machining.joining.beam import Material, Segment, tool_receptance
from machining.joining.coupling import joined_tip, with_joint, with_rotations

__all__ = [
    'Material',
    'Segment',
    'joined_tip',
    'tool_receptance',
    'with_joint',
    'with_rotations',
]
