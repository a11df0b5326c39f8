"""Gravity is data: what accelerometers read at rest, before any dynamics.

In come the means of the recordings in every pose; out go zero offsets, wrong units, swapped or
turned sensors, a robot off level and encoders that read wrong, and model and campaign put right.
"""

from model_gap.gravity.at_rest import AtRest, rest_of
from model_gap.gravity.faults import Fault, Kind
from model_gap.gravity.put_right import as_it_stands, left_open, put_right, right_units
from model_gap.gravity.weigh import encoders_told, weigh
from model_gap.gravity.weighed_again import same_put_right, standing_as, weighed_again

__all__ = [
    'AtRest',
    'Fault',
    'Kind',
    'as_it_stands',
    'encoders_told',
    'left_open',
    'put_right',
    'rest_of',
    'right_units',
    'same_put_right',
    'standing_as',
    'weigh',
    'weighed_again',
]
