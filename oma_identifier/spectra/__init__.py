"""Spectra of a window, and the lines in them.

In come uniform samples; out go singular values of their cross-spectral density, peaks, and
lines of machines, told from modes by an F test (Thomson 1982, doi:10.1109/PROC.1982.12433).
"""

from oma_identifier.spectra.harmonics import Line, line_at
from oma_identifier.spectra.line_evidence import LineEvidence, narrow_peaks_hz, peaks_hz
from oma_identifier.spectra.line_removal import without_lines
from oma_identifier.spectra.line_search import power as spectral_power
from oma_identifier.spectra.peaks import SpectralPeaks
from oma_identifier.spectra.spectrum import (
    empty_spectrum,
    REFRESHED,
    singular_value_spectrum,
    SingularValueSpectrum,
    SlidingSpectrum,
)
from oma_identifier.spectra.thresholds import SPECTRA

__all__ = [
    'REFRESHED',
    'SPECTRA',
    'Line',
    'LineEvidence',
    'SingularValueSpectrum',
    'SlidingSpectrum',
    'SpectralPeaks',
    'empty_spectrum',
    'line_at',
    'narrow_peaks_hz',
    'peaks_hz',
    'singular_value_spectrum',
    'spectral_power',
    'without_lines',
]
