"""Robots under ros2_control: plans as joint trajectories, and who plays them.

In come plans; out go trajectories that a ``joint_trajectory_controller`` interpolates as the
planner does.
"""

from robot_bridge.trajectory.joint_goal import joint_goal, JointGoal, reach
from robot_bridge.trajectory.joint_link import JointLink
from robot_bridge.trajectory.trajectory_control import TrajectoryControl, TrajectoryLink

__all__ = ['JointGoal', 'JointLink', 'TrajectoryControl', 'TrajectoryLink', 'joint_goal', 'reach']
