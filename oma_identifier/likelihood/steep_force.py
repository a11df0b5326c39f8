"""Forces whose density ends within a band, as behind a low-pass filter: they have no one slope."""

import math

from oma_identifier.likelihood.band_model import BandFit
from oma_identifier.likelihood.thresholds import LIKELIHOOD


def is_steep(fit: BandFit) -> bool:
    """Tell whether the data contradict what is assumed of a slope before them.

    What they say alone is the fit, freed of the prior that it was drawn to.
    """
    before = LIKELIHOOD.slope_std**-2.0
    precision = fit.slope_std**-2.0 - before
    if not precision > 0.0:
        return False
    value = abs(fit.model.slope) * (precision + before) / precision
    expected = math.sqrt(LIKELIHOOD.slope_std**2 + 1.0 / precision)
    return bool(value - LIKELIHOOD.integrated_twice > LIKELIHOOD.steep * expected)
