"""Which poles are modes of the structure.

In come poles of all orders; out go modes: poles that repeat from order to order are clustered,
and clusters judged by damping, scatter, phases and peaks.
"""

from oma_identifier.selection.band_selector import BandSelector
from oma_identifier.selection.identified import (
    harmonic,
    Identified,
    line_evidence,
    no_poles,
    renumbered,
    with_lines,
    without_explained,
    without_modes,
)
from oma_identifier.selection.join_bands import join_bands
from oma_identifier.selection.line_decision import (
    is_line,
    lines_among,
    LineTest,
    SAME_LINE,
    Suspect,
    suspicious,
)
from oma_identifier.selection.new_modes import NewModeTest, without_doubtful
from oma_identifier.selection.selection import select_in_band
from oma_identifier.selection.ssi_poles import identify_band
from oma_identifier.selection.stabilise import BandPoles

__all__ = [
    'SAME_LINE',
    'BandPoles',
    'BandSelector',
    'Identified',
    'LineTest',
    'NewModeTest',
    'Suspect',
    'harmonic',
    'identify_band',
    'is_line',
    'join_bands',
    'line_evidence',
    'lines_among',
    'no_poles',
    'renumbered',
    'select_in_band',
    'suspicious',
    'with_lines',
    'without_doubtful',
    'without_explained',
    'without_modes',
]
