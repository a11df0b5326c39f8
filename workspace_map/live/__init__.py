"""A map asked while the arm moves.

In come poses, one after the other; out go the modes of each with ids that last, and the depth a
cut may have there.
"""

from workspace_map.live.cut_limit import cut_limit
from workspace_map.live.motion_modes import ModesHere, MotionModes

__all__ = ['ModesHere', 'MotionModes', 'cut_limit']
