"""Sensors in step: how late each is against the others, from the responses alone.

In comes a window; out go its samples with delays put right, and the sensors that do not show
the motion the others show. Phases and beats at the peaks of the spectra give the odds of a
delay; coherence tells who hears something else; the shapes at the peaks tell who is not what it
was.
"""

from oma_identifier.synchrony.change_kind import CHANGES
from oma_identifier.synchrony.in_step import Synchroniser
from oma_identifier.synchrony.interruptions import INTERRUPTED, Interruptions
from oma_identifier.synchrony.sensor_changes import SensorChanges

__all__ = ['CHANGES', 'INTERRUPTED', 'Interruptions', 'SensorChanges', 'Synchroniser']
