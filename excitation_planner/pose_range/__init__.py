"""How far joints may move around a pose before a natural frequency changes too much.

In come a model and a pose; out go the dynamic sensitivity coefficients and the allowed range
(Jiao et al. 2025, doi:10.1038/s41598-025-95339-6, Eqs. 1 and 5 to 11).
"""

from excitation_planner.pose_range.allowed_range import (
    allowed_range,
    AllowedRange,
    is_allowed,
    largest_change,
)
from excitation_planner.pose_range.sensitivity import (
    actual_change,
    expanded_shapes,
    sensitivity_table,
    SensitivityTable,
)

__all__ = [
    'AllowedRange',
    'SensitivityTable',
    'actual_change',
    'allowed_range',
    'expanded_shapes',
    'is_allowed',
    'largest_change',
    'sensitivity_table',
]
