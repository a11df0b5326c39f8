"""Spectra of a window, and the lines in them.

In come uniform samples; out go singular values of their cross-spectral density, peaks, and
lines of machines, told from modes by an F test (Thomson 1982, doi:10.1109/PROC.1982.12433).
"""

from oma_identifier.spectra.harmonics import CHANCE, CHANCE_SHARP, Line, line_at, SUSPECT_DAMPING
from oma_identifier.spectra.line_evidence import LineEvidence
from oma_identifier.spectra.line_or_mode import FOR_MODE
from oma_identifier.spectra.line_removal import without_lines
from oma_identifier.spectra.peaks import SpectralPeaks
from oma_identifier.spectra.spectrum import (
    empty_spectrum,
    REFRESHED,
    singular_value_spectrum,
    SingularValueSpectrum,
    SlidingSpectrum,
)

__all__ = [
    'CHANCE',
    'CHANCE_SHARP',
    'FOR_MODE',
    'REFRESHED',
    'SUSPECT_DAMPING',
    'Line',
    'LineEvidence',
    'SingularValueSpectrum',
    'SlidingSpectrum',
    'SpectralPeaks',
    'empty_spectrum',
    'line_at',
    'singular_value_spectrum',
    'without_lines',
]
