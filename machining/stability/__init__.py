"""Chatter: in come modes or a response at the tool and a cut; out go limiting depths."""

from machining.stability.chance import (
    is_uncertain,
    LimitSample,
    LimitsOf,
    linear_std,
    sampled_limits,
    sampled_tools,
)
from machining.stability.period_map import spectral_radius
from machining.stability.semi_discretisation import DepthSearch, limits_of_periods
from machining.stability.zeroth_order import Limits, limits_of_modes, limits_of_response

__all__ = [
    'DepthSearch',
    'LimitSample',
    'Limits',
    'LimitsOf',
    'is_uncertain',
    'limits_of_modes',
    'limits_of_periods',
    'limits_of_response',
    'linear_std',
    'sampled_limits',
    'sampled_tools',
    'spectral_radius',
]
