"""Poles, shapes and masses that describe all frequency response functions of a band at once.

In come the lines of a band; out goes the modal model of largest likelihood.
"""

from impact_testing.fit.free_fit import free_fit, FreePoint, left_by
from impact_testing.fit.likely_force import force_doubt
from impact_testing.fit.modal_model import ModalModel, synthesised
from impact_testing.fit.mode_search import fitted, refitted
from impact_testing.fit.places import Places
from impact_testing.fit.start_poles import start_poles

__all__ = [
    'FreePoint',
    'ModalModel',
    'Places',
    'fitted',
    'force_doubt',
    'free_fit',
    'left_by',
    'refitted',
    'start_poles',
    'synthesised',
]
