"""What taps say of the structure: spectra of each point, FRFs, and their lines in a band.

In come judged taps; out go frequency response functions with the scatter of each line, and the
terms that a pole brings into them.
"""

from impact_testing.responses.band_data import band_lines, PointData
from impact_testing.responses.basis import (
    apart,
    bells,
    derivatives,
    functions,
    residual_terms,
)
from impact_testing.responses.frf import PointFrf
from impact_testing.responses.rest_before import at_rest_before
from impact_testing.responses.spectra import PointSpectra, Pulse
from impact_testing.responses.tap_scatter import of_the_mean, tap_scatter

__all__ = [
    'PointData',
    'PointFrf',
    'PointSpectra',
    'Pulse',
    'apart',
    'at_rest_before',
    'band_lines',
    'bells',
    'derivatives',
    'functions',
    'of_the_mean',
    'residual_terms',
    'tap_scatter',
]
