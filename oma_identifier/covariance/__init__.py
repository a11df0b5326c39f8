"""Frequency bands, and the output covariances of each.

In come uniform samples; out go, per band, decimated samples summed into covariances at positive
lags, kept block by block so that windows may overlap and their scatter be told (Reynders,
Pintelon and De Roeck 2008, doi:10.1016/j.ymssp.2007.10.009).
"""

from oma_identifier.covariance.analysed_band import (
    analysed_band,
    AnalysedBand,
    below_edge,
    sharp_edge_hz,
)
from oma_identifier.covariance.bands import Band, plan_bands, STEP
from oma_identifier.covariance.condition import BandConditioner, Decimation, Decimator
from oma_identifier.covariance.hankel_gram import HankelGram
from oma_identifier.covariance.output_covariance import (
    CovarianceAccumulator,
    OutputCovariance,
    WhenFull,
)
from oma_identifier.covariance.references import choose_references
from oma_identifier.covariance.thresholds import COVARIANCE

__all__ = [
    'COVARIANCE',
    'STEP',
    'AnalysedBand',
    'Band',
    'BandConditioner',
    'CovarianceAccumulator',
    'Decimation',
    'Decimator',
    'HankelGram',
    'OutputCovariance',
    'WhenFull',
    'analysed_band',
    'below_edge',
    'choose_references',
    'plan_bands',
    'sharp_edge_hz',
]
