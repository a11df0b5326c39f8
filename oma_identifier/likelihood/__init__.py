"""The Whittle likelihood of a few modes in one band of the spectra.

In come Fourier transforms of all channels and modes to start from; out go the modes that
explain the spectra best, with the covariance of their errors (Whittle 1953; Au 2017,
doi:10.1007/978-981-10-4118-1).
"""

from oma_identifier.likelihood.averages import averages_from
from oma_identifier.likelihood.band_model import (
    accelerance,
    BandData,
    BandFit,
    BandModel,
    expected_spectra,
    force_colour,
    forced_gain,
)
from oma_identifier.likelihood.continued import continued
from oma_identifier.likelihood.fit_band import (
    ConvergenceLimits,
    FIRST_PASS,
    fit_band,
    LATER_PASS,
    value_at,
)
from oma_identifier.likelihood.force_course import ForceCourse
from oma_identifier.likelihood.group_fits import (
    fit_group,
    fit_with_residuals,
    GroupFit,
    unit,
    updated,
    whole_shape,
)
from oma_identifier.likelihood.indices import BandIndex, ModeIndex
from oma_identifier.likelihood.known_fit import fit_known
from oma_identifier.likelihood.least_scatter import (
    least_blur,
    least_scatter,
    with_least_scatter,
)
from oma_identifier.likelihood.line_spectra import (
    inputs_of,
    moving_channels,
    Spectra,
    spectra_of,
    usable_lines,
)
from oma_identifier.likelihood.modal_motion import averaged_blocks, expected_motion
from oma_identifier.likelihood.mode_groups import group_modes, overlaps, StartModes
from oma_identifier.likelihood.reduced_band import ReducedBand
from oma_identifier.likelihood.shape_scatter import MacLoss, normalised_std
from oma_identifier.likelihood.steep_force import is_steep
from oma_identifier.likelihood.tail_regression import parts_along, TailData
from oma_identifier.likelihood.thresholds import LIKELIHOOD

__all__ = [
    'FIRST_PASS',
    'LATER_PASS',
    'LIKELIHOOD',
    'BandData',
    'BandFit',
    'BandIndex',
    'BandModel',
    'ConvergenceLimits',
    'ForceCourse',
    'GroupFit',
    'MacLoss',
    'ModeIndex',
    'ReducedBand',
    'Spectra',
    'StartModes',
    'TailData',
    'accelerance',
    'averaged_blocks',
    'averages_from',
    'continued',
    'expected_motion',
    'expected_spectra',
    'fit_band',
    'fit_group',
    'fit_known',
    'fit_with_residuals',
    'force_colour',
    'forced_gain',
    'group_modes',
    'inputs_of',
    'is_steep',
    'least_blur',
    'least_scatter',
    'moving_channels',
    'normalised_std',
    'overlaps',
    'parts_along',
    'spectra_of',
    'unit',
    'updated',
    'usable_lines',
    'value_at',
    'whole_shape',
    'with_least_scatter',
]
