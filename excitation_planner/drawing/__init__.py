"""The motion a request asks for: in come a request, a robot and a seed; out goes a trajectory.

And the noise that excites the modes that are expected, most where one would drown.
"""

from excitation_planner.drawing.drawing import draw_motion, find_allowed_range
from excitation_planner.drawing.exciting import exciting

__all__ = ['draw_motion', 'exciting', 'find_allowed_range']
