"""Spectra over time and over the speed of joints (Campbell diagram), with the tracked modes."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_core.window import ResultOfWindow
from modal_reports.charts.plain_numbers import number, numbers
from modal_reports.quantities import DAMPING, FREQUENCY

Array = NDArray[np.float64]
MOST_ROWS = 256
"""Frequencies drawn, about as many as a chart has pixels."""
FAINT_DB, STEPS = 60.0, 254
"""Range of the colours below the strongest, and their steps; step 255 is what was not measured."""
DEGREES = 180.0 / np.pi


@dataclass(frozen=True, slots=True)
class SpeedSpectra:
    """Mean spectra over the speed of one joint.

    Parameters
    ----------
    joint : str
        Its name.
    speed_rad_s : (n_bins,) array [rad/s]
        Middles of the bins; a speed is the mean of its magnitude over a segment.
    psd : (n_bins, n_lines) array [(SI unit)²/Hz]
        NaN where the joint never had that speed.
    window_rad_s : (n_windows, 3) array [rad/s]
        Mean, least and greatest speed of the segments in each window of the recording; NaN where
        not known.
    turns : tuple of float
        Of each motor shaft for one turn of this joint, those that it turns; empty without a robot.
    """

    joint: str
    speed_rad_s: Array
    psd: Array
    window_rad_s: Array
    turns: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Spectrogram:
    """Spectra of what was measured, rigid motion and lines of drives included.

    Parameters
    ----------
    frequency_hz : (n_lines,) array [Hz]
        Ascending, evenly spaced.
    time_s : (n_columns,) array [s]
        Middles of the columns, from the begin of the first window.
    psd : (n_columns, n_lines) array [(SI unit)²/Hz]
        Power spectral density, the mean over the channels.
    joints : tuple of SpeedSpectra
        Of the joints that move.
    """

    frequency_hz: Array
    time_s: Array
    psd: Array
    joints: tuple[SpeedSpectra, ...] = ()


def spectrogram_data(
    spectrogram: Spectrogram | None,
    windows: Sequence[ResultOfWindow],
    band_hz: tuple[float, float],
) -> dict[str, object] | None:
    """Return what the chart draws; None without spectra in the band.

    Parameters
    ----------
    spectrogram : Spectrogram or None
        Spectra.
    windows : sequence of ResultOfWindow
        The same windows in the same order, for their modes and lines.
    band_hz : (float, float) [Hz]
        That modes were looked for in.
    """
    if spectrogram is None:
        return None
    hz = spectrogram.frequency_hz
    rows = np.flatnonzero((hz >= band_hz[0]) & (hz <= band_hz[1]))
    if len(rows) < 2:
        return None
    shown = slice(int(rows[0]), int(rows[-1]) + 1)
    pooled = -(-len(rows) // MOST_ROWS)
    step_hz = float(hz[1] - hz[0])
    origin = windows[0].start_ns if windows else 0
    return {
        'low_hz': number(float(hz[shown][0]) - 0.5 * step_hz),
        'row_hz': number(step_hz * pooled),
        'n_rows': len(rows) // pooled,
        'time': {
            'step': number(2.0 * float(spectrogram.time_s[0])),
            **_picture(spectrogram.psd[:, shown], pooled),
        },
        'joints': [
            {
                'name': each.joint,
                'step': number(DEGREES * 2.0 * float(each.speed_rad_s[0])),
                **_picture(each.psd[:, shown], pooled),
                'windows': numbers(DEGREES * each.window_rad_s),
                'turns': [number(value) for value in each.turns],
            }
            for each in spectrogram.joints
        ],
        'windows': [
            [
                number((window.start_ns - origin) / NANOSECONDS_PER_SECOND),
                number((window.end_ns - origin) / NANOSECONDS_PER_SECOND),
            ]
            for window in windows
        ],
        'marks': [
            {
                'window': row,
                'id': int(mode.id),
                'frequency_hz': number(mode.frequency_hz),
                'std_hz': number(mode.frequency_std_hz),
                'harmonic': bool(mode.harmonic),
                'words': _words(mode),
            }
            for row, window in enumerate(windows)
            for mode in (*window.modes, *window.harmonics)
        ],
    }


def _words(mode: Mode) -> str:
    frequency = FREQUENCY.text(mode.frequency_hz, mode.frequency_std_hz)
    if mode.harmonic:
        return f'line of a machine or drive\n{frequency}'
    damping = DAMPING.text(mode.damping_ratio, mode.damping_ratio_std)
    return f'{f"mode {mode.id}" if mode.id else "not tracked"}\n{frequency}\ndamping {damping}'


def _picture(psd: Array, pooled: int) -> dict[str, object]:
    """Return a picture's columns as bytes of decibels below the strongest."""
    n_rows = psd.shape[1] // pooled
    power = psd[:, : n_rows * pooled].reshape(len(psd), n_rows, pooled).mean(axis=2)
    known = np.isfinite(power)
    top = float(power[known].max(initial=0.0)) or 1.0
    with np.errstate(divide='ignore'):
        below = -10.0 * np.log10(np.where(known, power, top) / top)
    step = np.round(STEPS * (1.0 - np.clip(below / FAINT_DB, 0.0, 1.0)))
    picture = np.where(known, step, STEPS + 1).astype(np.uint8)
    return {
        'n_columns': len(picture),
        'top': number(top),
        'faint_db': FAINT_DB,
        'levels': base64.b64encode(picture.tobytes()).decode('ascii'),
    }
