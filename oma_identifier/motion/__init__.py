"""What the robot's own motion adds to the responses.

In come a window and the joint states; out go responses without rigid motion and without orders
of the drives, delays between sensors and joints, and a test whether a peak is the joints' own
motion.
"""

from oma_identifier.motion.known_inputs import with_inputs
from oma_identifier.motion.rigid_motion import LATE
from oma_identifier.motion.robot_motion import in_model_order, load_robot_motion, RobotMotion
from oma_identifier.motion.robot_signals import Cleaned, never, PeakTest, RobotSignals, with_flags
from oma_identifier.motion.sensor_lag import Lag

__all__ = [
    'LATE',
    'Cleaned',
    'Lag',
    'PeakTest',
    'RobotMotion',
    'RobotSignals',
    'in_model_order',
    'load_robot_motion',
    'never',
    'with_flags',
    'with_inputs',
]
