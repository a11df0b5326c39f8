"""The ways a plan gets to an arm: guided cycle by cycle, or as a program that is followed.

In come plans and packets; out go replies, modules and what the operator should know.
"""

from robot_bridge.backends.backends import (
    BACKENDS,
    BackendSettings,
    is_real,
    make_backend,
    ROS2_CONTROL,
)

__all__ = ['BACKENDS', 'ROS2_CONTROL', 'BackendSettings', 'is_real', 'make_backend']
