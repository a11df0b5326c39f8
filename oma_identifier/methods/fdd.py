"""Frequency domain decomposition: peaks of singular values, and their damping without leakage.

The enhanced method takes the damping from the decay of a band-passed correlation of a smoothed
spectrum, which adds the width of the spectral window to that of the mode.  Here the bell of each
mode is fitted in the raw periodogram of its modal coordinate, which has no window.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mpc, mpd, normalise
from modal_core.samples import Samples
from oma_identifier.likelihood import averages_from, BandModel, fit_band
from oma_identifier.methods.decomposition import bell, decompose, Decomposition, peaks
from oma_identifier.methods.thresholds import METHOD
from oma_identifier.refinement import Outcome, refine, REFINEMENT, TAKEN

WHOLE = (0.0, np.inf)


def fdd(
    samples: Samples,
    spectrum: Decomposition | None = None,
    band_hz: tuple[float, float] = WHOLE,
) -> ModeSet:
    """Return the modes at the significant peaks of the first singular value, without damping.

    A line of the spectrum is no estimate with a known scatter: all deviations are NaN.

    Parameters
    ----------
    samples : Samples
        Responses.
    spectrum : Decomposition or None
        Of the samples; None: of its usual resolution.
    band_hz : (2,) tuple [Hz]
        Peaks outside are left alone.

    Raises no error when there is no peak: the set is empty.
    """
    spectrum = spectrum or decompose(samples)
    modes = []
    for peak in _inside(spectrum, band_hz):
        shape = normalise(spectrum.vector[peak] * spectrum.scale)
        modes.append(_mode(_parabola(spectrum, peak), np.nan, shape))
    return ModeSet(tuple(modes), samples.channel_names, 'fdd')


def _inside(spectrum: Decomposition, band_hz: tuple[float, float]) -> NDArray[np.int64]:
    found = peaks(spectrum)
    place_hz = spectrum.frequency_hz[found]
    return found[(place_hz >= band_hz[0]) & (place_hz <= band_hz[1])]


def efdd(
    samples: Samples,
    spectrum: Decomposition | None = None,
    band_hz: tuple[float, float] = WHOLE,
) -> ModeSet:
    """Return the modes at the peaks with frequency and damping fitted over their bells.

    A peak whose bell cannot be fitted is left out.  Deviations are those of the likelihood of all
    bells that overlap; NaN where it does not hold.

    Parameters
    ----------
    samples : Samples
        Responses.
    spectrum : Decomposition or None
        Of the samples; None: of its usual resolution.
    band_hz : (2,) tuple [Hz]
        Peaks outside are left alone.

    References
    ----------
    Jacobsen, Andersen and Brincker (2006), IMAC XXIV, Using enhanced frequency domain
    decomposition as a robust technique to harmonic excitation (bells).
    """
    spectrum = spectrum or decompose(samples)
    lines = _inside(spectrum, band_hz)
    if len(lines) == 0:
        return ModeSet((), samples.channel_names, 'efdd')
    rows = samples.widened()
    rows = (rows - rows.mean(axis=0)) / np.where(spectrum.scale > 0.0, spectrum.scale, np.inf)
    shapes = spectrum.vector[lines].T
    filters = _modal_filters(shapes)
    every = rfft(rows, axis=0) / np.sqrt(len(rows))
    frequency = np.arange(len(every)) * samples.sample_rate_hz / len(rows)
    modes = []
    for index, line in enumerate(lines):
        low, high = bell(spectrum, int(line))
        inside = (frequency > low) & (frequency < high)
        start_hz = _parabola(spectrum, int(line))
        found = _fit(frequency[inside], every[inside] @ filters[index], start_hz)
        if found is not None:
            shape = normalise(shapes[:, index] * spectrum.scale)
            modes.append(_mode(found[0], found[1], shape, found[2], found[3]))
    modes.sort(key=lambda mode: mode.frequency_hz)
    # Bells that overlap are fitted once more, together; of two close modes often only one peaks.
    refined = refine(samples, ModeSet(tuple(modes), samples.channel_names, 'efdd'))
    joined = [
        *map(_with_known_std, refined.modes, refined.outcomes),
        *(
            mode
            for mode, misfit in zip(refined.added, refined.added_misfit, strict=True)
            if misfit < REFINEMENT.adopted_misfit and band_hz[0] <= mode.frequency_hz <= band_hz[1]
        ),
    ]
    joined.sort(key=lambda mode: mode.frequency_hz)
    return ModeSet(tuple(joined), samples.channel_names, 'efdd')


def _with_known_std(mode: Mode, outcome: Outcome) -> Mode:
    """Return a mode without deviations where its bell is not described with those beside it.

    Those of a bell alone do not hold what its neighbours bend it by: of 60 frequencies of random
    structures 82 % were within 2σ.
    """
    if outcome in TAKEN:
        return mode
    return replace(mode, frequency_std_hz=np.nan, damping_ratio_std=np.nan)


def _modal_filters(shapes: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return rows that pick one shape each and, with channels enough, none of the others."""
    n_channels, n_modes = shapes.shape
    unit = shapes / np.linalg.norm(shapes, axis=0)
    if n_modes < n_channels and np.linalg.cond(unit) < 10.0:
        return np.asarray(np.linalg.pinv(unit))
    return np.asarray(unit.conj().T)


def _parabola(spectrum: Decomposition, line: int) -> float:
    """Return the peak of the parabola through ln σ₁ at three lines [Hz]."""
    values = np.log(spectrum.singular_value[line - 1 : line + 2, 0])
    curvature = values[0] - 2.0 * values[1] + values[2]
    offset = 0.5 * (values[0] - values[2]) / curvature if curvature < 0.0 else 0.0
    return float(spectrum.frequency_hz[line] + offset * spectrum.frequency_hz[1])


def _fit(
    frequency_hz: NDArray[np.float64], coordinate: NDArray[np.complex128], start_hz: float
) -> tuple[float, float, float, float] | None:
    """Fit one mode; the best of several starts of the damping, bells cut to what it needs."""
    damping = 0.02
    result = None
    for _ in range(3):  # the width of the bell follows the damping
        reach = max(
            METHOD.bell_half_widths * damping * start_hz, 6.0 * (frequency_hz[1] - frequency_hz[0])
        )
        near = np.abs(frequency_hz - start_hz) < reach
        if np.count_nonzero(near) < 12:
            return None
        data = averages_from(
            frequency_hz[near],
            coordinate[near, None],
            np.array([start_hz]),
            np.array([damping * start_hz]),
        )
        power = float(np.mean(np.abs(coordinate[near]) ** 2))
        model = BandModel(
            np.array([start_hz]),
            np.array([damping]),
            np.ones((1, 1), dtype=complex),
            np.array([[power * damping]], dtype=complex),
            np.array([1e-3 * power]),
            1,
            reference_hz=start_hz,
        )
        fit = fit_band(data, model)
        if not fit.converged:
            return None
        start_hz, damping = float(fit.model.frequency_hz[0]), float(fit.model.damping_ratio[0])
        result = (
            start_hz,
            damping,
            float(fit.frequency_std[0]) * start_hz,
            float(fit.damping_ratio_std[0]) * damping,
        )
    return result


def _mode(
    frequency_hz: float,
    damping_ratio: float,
    shape: NDArray[np.complex128],
    frequency_std_hz: float = np.nan,
    damping_ratio_std: float = np.nan,
) -> Mode:
    return Mode(
        frequency_hz,
        damping_ratio,
        shape,
        frequency_std_hz,
        damping_ratio_std,
        mpc=float(mpc(shape[:, None])[0]),
        mpd=float(mpd(shape[:, None])[0]),
    )
