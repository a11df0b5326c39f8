"""A modal map measured on an arm: a series of motions, released once, and what comes of it.

In come a robot and what is wanted; out go a series of checked motions with one hash, recordings,
and a map that is written whole after every pose.
"""

from autonomous_modal_analysis.mapping.measuring import MappingFolder, measure
from autonomous_modal_analysis.mapping.series import (
    MapWish,
    plan_series,
    plan_way,
    request_of,
    Series,
    Stop,
)
from autonomous_modal_analysis.mapping.series_release import SeriesRelease

__all__ = [
    'MapWish',
    'MappingFolder',
    'Series',
    'SeriesRelease',
    'Stop',
    'measure',
    'plan_series',
    'plan_way',
    'request_of',
]
