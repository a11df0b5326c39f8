"""The planner as a ROS node: in come parameters and services; out goes a sealed plan.

Nothing here moves a robot.
"""
