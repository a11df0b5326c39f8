"""Which poles are modes of the structure.

In come poles of all orders; out go modes: poles that repeat from order to order are clustered,
and clusters judged by damping, scatter, phases and peaks.
"""

from oma_identifier.selection.band_selector import BandSelector
from oma_identifier.selection.cluster import Cluster, cluster_poles
from oma_identifier.selection.new_modes import NewModeTest, without_doubtful
from oma_identifier.selection.selection import (
    BandSelection,
    select_in_band,
    SelectedPole,
    without_repeats,
)
from oma_identifier.selection.ssi_poles import identify_band
from oma_identifier.selection.stabilise import BandPoles, stabilise

__all__ = [
    'BandPoles',
    'BandSelection',
    'BandSelector',
    'Cluster',
    'NewModeTest',
    'SelectedPole',
    'cluster_poles',
    'identify_band',
    'select_in_band',
    'stabilise',
    'without_doubtful',
    'without_repeats',
]
