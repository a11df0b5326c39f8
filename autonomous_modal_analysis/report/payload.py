"""The numbers the report's charts draw, as plain JSON values."""

import itertools

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.report.content import ReportContent, Spectrum
from autonomous_modal_analysis.report.words import STATUS_WORDS
from autonomous_modal_analysis.results import plain
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_core.poles import PoleStatus, PoleTable

MOST_FREQUENCIES = 2000
MOST_SINGULAR_VALUES = 6
DIGITS = 7
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


def payload(content: ReportContent) -> dict[str, object]:
    """Return everything the report's scripts draw.

    Parameters
    ----------
    content : ReportContent
        What the report says.

    Returns
    -------
    dict
        Keys ``modes``, ``harmonics``, ``poles``, ``groups``, ``status_words``, ``spectrum``,
        ``windows``, ``geometry``, ``channel_names``; plain values, rounded to seven digits.
    """
    identification = content.identification
    true_by_mode = {id(true.mode): true for true in content.truth or () if true.mode is not None}
    modes = []
    for index, mode in enumerate(identification.modes):
        entry = _mode(mode)
        true = true_by_mode.get(id(mode))
        entry['true_frequency_hz'] = _number(true.frequency_hz) if true else None
        entry['true_damping_ratio'] = _number(true.damping_ratio) if true else None
        entry['shape_real'] = _numbers(np.real(mode.shape))
        entry['shape_imag'] = _numbers(np.imag(mode.shape))
        if content.geometry is not None and index < len(content.displacements):
            moved = np.asarray(content.displacements[index])
            entry['moved_real'] = _numbers(moved.real)
            entry['moved_imag'] = _numbers(moved.imag)
        modes.append(entry)
    return {
        'modes': modes,
        'harmonics': [_mode(line) for line in identification.harmonics],
        'poles': _poles(content.poles),
        'groups': [
            {'key': key, 'label': label, 'status': [int(status) for status in statuses]}
            for key, label, statuses in POLE_GROUPS
        ],
        'status_words': [STATUS_WORDS[status] for status in PoleStatus],
        'spectrum': _spectrum(content.spectrum),
        'windows': _windows(content),
        'geometry': _geometry(content),
        'channel_names': list(identification.modes.channel_names),
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


def _mode(mode: Mode) -> dict[str, object]:
    return {
        'id': int(mode.id),
        'frequency_hz': _number(mode.frequency_hz),
        'frequency_std_hz': _number(mode.frequency_std_hz),
        'damping_ratio': _number(mode.damping_ratio),
        'damping_ratio_std': _number(mode.damping_ratio_std),
        'harmonic': bool(mode.harmonic),
    }


def _poles(poles: PoleTable | None) -> dict[str, object] | None:
    if poles is None or len(poles) == 0:
        return None
    return {
        'frequency_hz': _numbers(poles.frequency_hz),
        'damping_ratio': _numbers(poles.damping_ratio),
        'model_order': plain(poles.model_order),
        'status': plain(poles.status),
        'mode_id': plain(poles.mode_id),
    }


def _spectrum(spectrum: Spectrum | None) -> dict[str, object] | None:
    if spectrum is None or len(spectrum.frequency_hz) == 0:
        return None
    shown = pooled(spectrum)
    values = shown.singular_value[:, :MOST_SINGULAR_VALUES]
    # A logarithmic axis has no place for zero.
    positive = np.where(values > 0.0, values, np.nan)
    return {
        'frequency_hz': _numbers(shown.frequency_hz),
        'singular_value': [_numbers(column) for column in positive.T],
    }


def _windows(content: ReportContent) -> list[dict[str, object]]:
    windows = content.identification.windows
    if not windows:
        return []
    origin = windows[0].start_ns
    return [
        {
            'index': window.index,
            'start_s': _number((window.start_ns - origin) / NANOSECONDS_PER_SECOND),
            'end_s': _number((window.end_ns - origin) / NANOSECONDS_PER_SECOND),
            'identifiable': window.quality.identifiable,
            'modes': [_mode(mode) for mode in window.modes],
        }
        for window in windows
    ]


def _geometry(content: ReportContent) -> dict[str, object] | None:
    geometry = content.geometry
    if geometry is None:
        return None
    return {
        'points_m': _numbers(np.asarray(geometry.points_m)),
        'lines': [list(map(int, line)) for line in geometry.lines],
        'sensors': list(map(int, geometry.sensors)),
    }


def _number(value: float) -> object:
    return plain(float(f'{value:.{DIGITS}g}'))


def _numbers(values: NDArray[np.float64]) -> object:
    if values.ndim > 1:
        return [_numbers(row) for row in values]
    return [_number(value) for value in values]
