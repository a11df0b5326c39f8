"""What a planned motion will show: in come spectra and a model; out go modes with their σ.

Participation and signal over noise of each mode, the directions that torques reach (Jiao et al.
2025, doi:10.1038/s41598-025-95339-6, Eqs. 17 to 20), and the modes that a map expects.
"""

from excitation_planner.forecast.expected_modes import ExpectedModes, pairs, with_expected
from excitation_planner.forecast.participation import (
    analysed_hz,
    cramer_rao_std,
    forecast,
    mode_participation,
    ModeForecast,
    ModeParticipation,
    PART_OF_BAND,
    VISIBLE_DB,
)
from excitation_planner.forecast.prediction import PlanPrediction
from excitation_planner.forecast.torque_projection import (
    direction_ratio,
    joint_axes,
    projection_along,
    require_full_rank,
    structure_torque,
    TorqueProjection,
)

__all__ = [
    'PART_OF_BAND',
    'VISIBLE_DB',
    'ExpectedModes',
    'ModeForecast',
    'ModeParticipation',
    'PlanPrediction',
    'TorqueProjection',
    'analysed_hz',
    'cramer_rao_std',
    'direction_ratio',
    'forecast',
    'joint_axes',
    'mode_participation',
    'pairs',
    'projection_along',
    'require_full_rank',
    'structure_torque',
    'with_expected',
]
