"""Ids of modes that last along a motion.

In come a map, poses of a motion and modes that were measured at some; out go ids, each of a shape
that is carried from pose to pose, and whether they are sure.
"""

from workspace_map.following.carrying import Carried, carried_on
from workspace_map.following.followed import Followed, followed_from, Named

__all__ = ['Carried', 'Followed', 'Named', 'carried_on', 'followed_from']
