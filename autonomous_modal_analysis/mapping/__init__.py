"""A modal map measured on an arm: a series of motions, released once, and what comes of it.

In come a robot and what is wanted; out go a series of checked motions with one hash, recordings,
and a map that is written whole after every pose.
"""

from autonomous_modal_analysis.mapping.measuring import MappingFolder, measure
from autonomous_modal_analysis.mapping.series import MapWish, plan_series, Series, Stop

__all__ = ['MapWish', 'MappingFolder', 'Series', 'Stop', 'measure', 'plan_series']
