"""Poles of all model orders from the covariances of a band.

In come output covariances; out go poles with shapes, and the standard deviations that the
scatter of the covariances gives them: covariance-driven subspace identification with references
(Peeters and De Roeck 1999, doi:10.1006/mssp.1999.1249), its data-driven and its combined form.
"""

from oma_identifier.subspace.band_stream import BandCovariance, BandStream
from oma_identifier.subspace.canonical import factorise_canonical
from oma_identifier.subspace.csi import combined_gram, combined_poles
from oma_identifier.subspace.record_streams import RecordStreams
from oma_identifier.subspace.ssi_cov import (
    factorise,
    HankelFactors,
    MultiOrder,
    OrderSolution,
    output_matrix,
    poles_of_orders,
    RawPoles,
)
from oma_identifier.subspace.ssi_data import data_gram, data_poles, poles_of_projection
from oma_identifier.subspace.thresholds import SUBSPACE
from oma_identifier.subspace.uncertainty import (
    deviation_from,
    influence,
    PoleDeviation,
    PoleSensitivity,
)

__all__ = [
    'SUBSPACE',
    'BandCovariance',
    'BandStream',
    'HankelFactors',
    'MultiOrder',
    'OrderSolution',
    'PoleDeviation',
    'PoleSensitivity',
    'RawPoles',
    'RecordStreams',
    'combined_gram',
    'combined_poles',
    'data_gram',
    'data_poles',
    'deviation_from',
    'factorise',
    'factorise_canonical',
    'influence',
    'output_matrix',
    'poles_of_orders',
    'poles_of_projection',
]
