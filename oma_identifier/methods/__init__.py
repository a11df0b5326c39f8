"""Methods beside covariance-driven subspace identification, by name.

In come samples; out go poles and modes by data-driven or combined subspace identification, by
the poly-reference least-squares method or by frequency domain decomposition, with standard
deviations by leaving out stretches in turn.
"""

from oma_identifier.methods.catalogue import CATALOGUE, identify_by, method_named, METHODS
from oma_identifier.methods.half_spectra import half_spectra, HalfSpectra, LagSums
from oma_identifier.methods.method import Method
from oma_identifier.methods.polyreference import NormalEquations

__all__ = [
    'CATALOGUE',
    'METHODS',
    'HalfSpectra',
    'LagSums',
    'Method',
    'NormalEquations',
    'half_spectra',
    'identify_by',
    'method_named',
]
