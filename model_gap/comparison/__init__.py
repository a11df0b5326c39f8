"""Model and measurement side by side, each figure with its uncertainty.

In come the records of a campaign and a model; out go pairs of spectra, of transmissibilities and
of modes, before and after the effects that were found.
"""

from model_gap.comparison.as_json import comparison_mapping
from model_gap.comparison.compare import compare_model, ModelComparison
from model_gap.comparison.spectra_pairs import SpectraPair, used_bands
from model_gap.comparison.transmissibility import SensorBand

__all__ = [
    'ModelComparison',
    'SensorBand',
    'SpectraPair',
    'compare_model',
    'comparison_mapping',
    'used_bands',
]
