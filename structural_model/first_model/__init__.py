"""A robot's folder from a URDF alone: one arm of it, and a guess of what no URDF says.

In comes a URDF as it is published; out go the files of a robot and what was guessed in them.
"""

from structural_model.first_model.first_robot import first_robot, FirstRobot

__all__ = ['FirstRobot', 'first_robot']
