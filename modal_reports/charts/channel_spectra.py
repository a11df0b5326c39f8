"""Spectra of single channels: measured, synthesised from the modes, and their coherence."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_reports.charts.plain_numbers import number

Array = NDArray[np.float64]
DIGITS = 4
"""That a chart of a report can show."""


@dataclass(frozen=True, slots=True)
class ChannelSpectra:
    """Spectra over one grid.

    Parameters
    ----------
    names : tuple of str
        Of the channels.
    reference : str
        That coherence is with.
    frequency_hz : (n_lines,) array [Hz]
        Ascending.
    psd, synthesised : (n_lines, n_channels) array [(SI unit)²/Hz]
        Power spectral densities: measured, and as the modes have them.
    coherence : (n_lines, n_channels) array
        Squared, with the reference.
    """

    names: tuple[str, ...]
    reference: str
    frequency_hz: Array
    psd: Array
    synthesised: Array
    coherence: Array


def channel_spectra_data(spectra: ChannelSpectra | None) -> dict[str, object] | None:
    """Return what the chart of channels draws; None without any."""
    if spectra is None or not len(spectra.frequency_hz):
        return None
    return {
        'names': list(spectra.names),
        'reference': spectra.reference,
        'frequency_hz': _short(spectra.frequency_hz, DIGITS + 2),
        'psd': [_short(_positive(column)) for column in spectra.psd.T],
        'synthesised': [_short(_positive(column)) for column in spectra.synthesised.T],
        'coherence': [_short(column, 3) for column in spectra.coherence.T],
    }


def _positive(values: Array) -> Array:
    # A logarithmic axis has no place for the others.
    return np.where(values > 0.0, values, np.nan)


def _short(values: Array, digits: int = DIGITS) -> list[float | None]:
    known = (number(value) for value in values.tolist())
    return [None if value is None else float(f'{value:.{digits}g}') for value in known]
