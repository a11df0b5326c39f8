"""How a mode changes with the level of its motion: cubic stiffness, cubic damping, or friction.

In come modes of one structure from recordings at three levels or more, and their samples.
Then out go laws of stiffness and damping with standard deviations, and responses of third order.
Moments of the motion and equivalent linearisation (Caughey 1963, doi:10.1121/1.1918794).
"""

from oma_identifier.levels.anchor import LevelStiffness, stiffness_at_levels
from oma_identifier.levels.cubic_mode import CubicMode
from oma_identifier.levels.law_fit import Law, LawFit
from oma_identifier.levels.level_law import level_law, LevelLaw, QuantityLaw
from oma_identifier.levels.modal_motion import ModalMotion, motions_at_levels
from oma_identifier.levels.narrow_band import ModeRecord
from oma_identifier.levels.own_share import OwnShare
from oma_identifier.levels.thresholds import LEVELS

__all__ = [
    'LEVELS',
    'CubicMode',
    'Law',
    'LawFit',
    'LevelLaw',
    'LevelStiffness',
    'ModalMotion',
    'ModeRecord',
    'OwnShare',
    'QuantityLaw',
    'level_law',
    'motions_at_levels',
    'stiffness_at_levels',
]
