"""Which poles are modes of the structure.

In come poles of all orders; out go modes: poles that repeat from order to order are clustered,
and clusters judged by damping, scatter, phases and peaks.
"""

from oma_identifier.selection.band_selector import BandSelector
from oma_identifier.selection.candidates import candidates_among
from oma_identifier.selection.cluster import cluster_poles
from oma_identifier.selection.identified import (
    harmonic,
    Identified,
    line_evidence,
    no_poles,
    nothing_in,
    only,
    renumbered,
    up_to,
    with_forced,
    with_lines,
    without_explained,
    without_modes,
    without_moments,
)
from oma_identifier.selection.join_bands import join_bands
from oma_identifier.selection.line_decision import (
    is_line,
    is_same_line,
    line_reach,
    lines_among,
    LineTest,
    Suspect,
    suspicious,
)
from oma_identifier.selection.new_modes import NewModeTest, without_doubtful
from oma_identifier.selection.selection import select_in_band
from oma_identifier.selection.ssi_poles import identify_band
from oma_identifier.selection.stabilise import BandPoles
from oma_identifier.selection.thresholds import SELECTION

__all__ = [
    'SELECTION',
    'BandPoles',
    'BandSelector',
    'Identified',
    'LineTest',
    'NewModeTest',
    'Suspect',
    'candidates_among',
    'cluster_poles',
    'harmonic',
    'identify_band',
    'is_line',
    'is_same_line',
    'join_bands',
    'line_evidence',
    'line_reach',
    'lines_among',
    'no_poles',
    'nothing_in',
    'only',
    'renumbered',
    'select_in_band',
    'suspicious',
    'up_to',
    'with_forced',
    'with_lines',
    'without_doubtful',
    'without_explained',
    'without_modes',
    'without_moments',
]
