"""What a hypothesis says the sensors read for the motion that was recorded.

In come a cell and records; out go predicted spectra: the linear arm, torques of joints stepped
in time, lines and transmission errors.
"""

from model_gap.predict.arm_change import ArmChange, forces, parts, stacked
from model_gap.predict.changing import Changing, changing, response_change
from model_gap.predict.driven import driven_motion
from model_gap.predict.hung import at_point, hung, link_motions
from model_gap.predict.joint_path import static_twist
from model_gap.predict.linearised import linearised
from model_gap.predict.predict import Predictor
from model_gap.predict.ripple import transform_at
from model_gap.predict.solved import Solved
from model_gap.predict.step_torque import compile_laws
from model_gap.predict.thresholds import PREDICTION

__all__ = [
    'PREDICTION',
    'ArmChange',
    'Changing',
    'Predictor',
    'Solved',
    'at_point',
    'changing',
    'compile_laws',
    'driven_motion',
    'forces',
    'hung',
    'linearised',
    'link_motions',
    'parts',
    'response_change',
    'stacked',
    'static_twist',
    'transform_at',
]
