"""Spectra of a recording over time and over the speed of every joint, gathered as it is read."""

from autonomous_modal_analysis.spectrogram.watch import SpectrogramWatch

__all__ = ['SpectrogramWatch']
