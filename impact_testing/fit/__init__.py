"""Poles, shapes and masses that describe all frequency response functions of a band at once.

In come the lines of a band; out goes the modal model of largest likelihood.
"""

from impact_testing.fit.delay import earlier, force_delay, ForceDelay
from impact_testing.fit.free_fit import free_fit, FreePoint, left_by
from impact_testing.fit.likely_force import force_doubt
from impact_testing.fit.modal_model import ModalModel, synthesised
from impact_testing.fit.mode_search import fitted, refitted
from impact_testing.fit.places import Places

__all__ = [
    'ForceDelay',
    'FreePoint',
    'ModalModel',
    'Places',
    'earlier',
    'fitted',
    'force_delay',
    'force_doubt',
    'free_fit',
    'left_by',
    'refitted',
    'synthesised',
]
