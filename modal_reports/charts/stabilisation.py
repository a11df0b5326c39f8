"""Stabilisation diagram: poles over the model order, on the singular-value spectrum."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
import itertools

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.poles import PoleStatus, PoleTable
from modal_reports.charts.plain_numbers import number, numbers

MOST_FREQUENCIES = 2000
MOST_SINGULAR_VALUES = 6
STATUS_WORDS = {
    PoleStatus.KEPT: 'belongs to a mode',
    PoleStatus.UNSTABLE_POLE: 'negative damping',
    PoleStatus.OVERDAMPED: 'damping above the limit',
    PoleStatus.OUT_OF_BAND: 'outside the analysed band',
    PoleStatus.FREQUENCY_NOT_STABLE: 'frequency differs from the order below',
    PoleStatus.DAMPING_NOT_STABLE: 'damping differs from the order below',
    PoleStatus.SHAPE_NOT_STABLE: 'shape differs from the order below',
    PoleStatus.UNCERTAIN: 'standard deviation too large',
    PoleStatus.COMPLEX_SHAPE: 'phases scatter too much for a mode',
    PoleStatus.SMALL_CLUSTER: 'too few orders agree',
    PoleStatus.HARMONIC: 'line of a machine or drive, not a mode',
    PoleStatus.CLUSTER_OUTLIER: 'far from the centre of its mode',
    PoleStatus.WEAK: 'contributes no more than noise',
}
# Groups a person tells apart; the exact reason shows on hover.
POLE_GROUPS: tuple[tuple[str, str, tuple[PoleStatus, ...]], ...] = (
    ('kept', 'belongs to a mode', (PoleStatus.KEPT,)),
    ('harmonic', 'harmonic', (PoleStatus.HARMONIC,)),
    (
        'candidate',
        'stable, not taken',
        (
            PoleStatus.UNCERTAIN,
            PoleStatus.COMPLEX_SHAPE,
            PoleStatus.SMALL_CLUSTER,
            PoleStatus.CLUSTER_OUTLIER,
            PoleStatus.WEAK,
        ),
    ),
    (
        'unstable',
        'not stable',
        (
            PoleStatus.FREQUENCY_NOT_STABLE,
            PoleStatus.DAMPING_NOT_STABLE,
            PoleStatus.SHAPE_NOT_STABLE,
        ),
    ),
    (
        'unphysical',
        'outside limits',
        (PoleStatus.UNSTABLE_POLE, PoleStatus.OVERDAMPED, PoleStatus.OUT_OF_BAND),
    ),
)


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Singular-value spectrum of the responses.

    Parameters
    ----------
    frequency_hz : (n_frequencies,) array [Hz]
        Ascending.
    singular_value : (n_frequencies, n_values) array [(m/s²)²/Hz]
        Of the cross-spectral density matrix, largest first.
    """

    frequency_hz: NDArray[np.float64]
    singular_value: NDArray[np.float64]


def stabilisation_data(
    poles: PoleTable | None,
    spectrum: Spectrum | None,
    lines: Iterable[Mode],
    pick: Mapping[str, str] | None = None,
) -> dict[str, object]:
    """Return what the stabilisation diagram draws.

    Parameters
    ----------
    poles : PoleTable or None
        Of all model orders.
    spectrum : Spectrum or None
        Behind them; pooled to what a screen shows.
    lines : iterable of Mode
        Modes and harmonics to mark by a line.
    pick : mapping of str to str or None
        Poles can be picked, and are saved in a file that says this too.
    """
    return {
        'pick': None if pick is None else dict(pick),
        'poles': _poles(poles),
        'spectrum': _spectrum(spectrum),
        'groups': [
            {'key': key, 'label': label, 'status': [int(status) for status in statuses]}
            for key, label, statuses in POLE_GROUPS
        ],
        'status_words': [STATUS_WORDS[status] for status in PoleStatus],
        'lines': [
            {
                'id': int(mode.id),
                'frequency_hz': number(mode.frequency_hz),
                'harmonic': bool(mode.harmonic),
            }
            for mode in sorted(lines, key=lambda mode: mode.frequency_hz)
        ],
    }


def pooled(spectrum: Spectrum, most: int = MOST_FREQUENCIES) -> Spectrum:
    """Return a spectrum of at most so many frequencies, keeping every peak's height.

    Parameters
    ----------
    spectrum : Spectrum
        Any resolution.
    most : int
        Largest number of frequencies.

    Returns
    -------
    Spectrum
        Each frequency stands for a run of neighbours: the place and values of its largest.
    """
    n_frequencies = len(spectrum.frequency_hz)
    if n_frequencies <= most:
        return spectrum
    edges = np.linspace(0, n_frequencies, most + 1).astype(int)
    first = np.nan_to_num(spectrum.singular_value[:, 0], nan=-np.inf)
    rows = [start + int(np.argmax(first[start:stop])) for start, stop in itertools.pairwise(edges)]
    return Spectrum(spectrum.frequency_hz[rows], spectrum.singular_value[rows])


def _poles(poles: PoleTable | None) -> dict[str, object] | None:
    if poles is None or len(poles) == 0:
        return None
    return {
        'frequency_hz': numbers(poles.frequency_hz),
        'damping_ratio': numbers(poles.damping_ratio),
        'model_order': poles.model_order.tolist(),
        'status': poles.status.tolist(),
        'mode_id': poles.mode_id.tolist(),
    }


def _spectrum(spectrum: Spectrum | None) -> dict[str, object] | None:
    if spectrum is None or len(spectrum.frequency_hz) == 0:
        return None
    shown = pooled(spectrum)
    values = shown.singular_value[:, :MOST_SINGULAR_VALUES]
    # A logarithmic axis has no place for zero.
    positive = np.where(values > 0.0, values, np.nan)
    return {
        'frequency_hz': numbers(shown.frequency_hz),
        'singular_value': [numbers(column) for column in positive.T],
    }
