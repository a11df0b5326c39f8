"""The robot as a flexible-joint model on pinocchio: M, C, K, modes, FRF, sensor Jacobians."""

from structural_model.description import ModelSpec, RobotLimits
from structural_model.equations import DampedModes, ModelModes, StructuralMatrices
from structural_model.first_model import first_robot, FirstRobot
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.robot_files import load_layout, load_robot
from structural_model.robot_writer import save_robot

__all__ = [
    'DampedModes',
    'FirstRobot',
    'FlexibleJointModel',
    'ModelModes',
    'ModelSpec',
    'RobotLimits',
    'StructuralMatrices',
    'first_robot',
    'load_layout',
    'load_robot',
    'save_robot',
]
