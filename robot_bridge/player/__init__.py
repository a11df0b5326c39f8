"""A plan as a path, and the references of every cycle along it.

In comes a checked plan; out go position and speed for the next cycle, with ramps in, out and to
standstill.
"""

from robot_bridge.player.plan_path import PlanPath
from robot_bridge.player.plan_player import PlanPlayer, PlayerSettings, Reference

__all__ = ['PlanPath', 'PlanPlayer', 'PlayerSettings', 'Reference']
