"""Spectra of two results over each other, with the modes of both."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modal_core.mode import Mode, ModeSet
from modal_reports.charts.plain_numbers import number
from modal_reports.charts.stabilisation import pooled, Spectrum
from modal_reports.quantities import DAMPING, FREQUENCY

MOST_LINES = 1500
"""Of a spectrum in the chart."""


@dataclass(frozen=True, slots=True)
class ComparedSpectrum:
    """One result.

    Parameters
    ----------
    name : str
        Of the recording.
    modes : ModeSet
        Its modes.
    spectrum : Spectrum or None
        Its largest singular value is drawn; without it, the modes alone.
    """

    name: str
    modes: ModeSet
    spectrum: Spectrum | None = None


def compared_spectra_data(states: Sequence[ComparedSpectrum]) -> dict[str, object] | None:
    """Return what the chart draws; None where no state has a spectrum."""
    if all(state.spectrum is None for state in states):
        return None
    return {
        'states': [
            {
                'name': state.name,
                **_curve(state.spectrum),
                'modes': [_mode(mode) for mode in state.modes],
            }
            for state in states
        ]
    }


def _curve(spectrum: Spectrum | None) -> dict[str, object]:
    if spectrum is None:
        return {'frequency_hz': [], 'singular_value': []}
    shown = pooled(spectrum, MOST_LINES)
    values = np.where(shown.singular_value[:, 0] > 0.0, shown.singular_value[:, 0], np.nan)
    return {
        'frequency_hz': [number(value) for value in shown.frequency_hz.tolist()],
        'singular_value': [number(value) for value in values.tolist()],
    }


def _mode(mode: Mode) -> dict[str, object]:
    return {
        'id': int(mode.id),
        'frequency_hz': number(mode.frequency_hz),
        'std_hz': number(mode.frequency_std_hz),
        'words': f'{FREQUENCY.text(mode.frequency_hz, mode.frequency_std_hz)}\n'
        f'damping {DAMPING.text(mode.damping_ratio, mode.damping_ratio_std)}',
    }
