"""Refine identified modes by maximum likelihood, all modes that overlap at once.

Subspace methods use the data well but not fully: their scatter is about one and a half times what
any method must have.  Starting from their modes, the likelihood of the spectra around each group
of modes is maximised; the result scatters near the limit and its standard deviations come from
the Fisher information.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from enum import StrEnum
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft

from modal_core.errors import LayoutError
from modal_core.indicators import mac, mpc, mpd, normalise
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.band_data import (
    band_lines,
    group_modes,
    reduce_band,
    ReducedBand,
    Spectra,
    StartModes,
)
from oma_identifier.one_thread import one_thread
from oma_identifier.shape_scatter import normalised_std
from oma_identifier.unlisted import with_unlisted
from oma_identifier.whittle import BandFit, fit_band, SlopePrior

PASSES = 2
"""The second pass has refined tails and shapes to project out."""
HIGHEST_SHARE = 0.435
"""Of the sample rate: above, anti-aliasing filters shape the spectrum."""
LEAST_LINES_PER_MODE = 12
FAR = 5.0
"""Standard deviations a refined mode may be away from its start."""
LEAST_MAC = 0.8
LARGEST_MISFIT = 3.0
SLOPE_STD = 1.0
"""Of the exponent of the force density, before the data: 3 dB per octave."""
SLOPE_REACH = 1.0
"""Distance in ln f over which the slope changes: an octave and a half."""
LINE_REACH = 4
"""Frequencies left out on both sides of a harmonic."""


class Outcome(StrEnum):
    """What became of one mode."""

    REFINED = 'refined'
    OUT_OF_BAND = 'out_of_band'
    TOO_SHORT = 'too_short'
    NOT_CONVERGED = 'not_converged'
    FAR_FROM_START = 'far_from_start'
    MODEL_MISFIT = 'model_misfit'
    NOT_TRIED = 'not_tried'


@dataclass(frozen=True, slots=True)
class Refinement:
    """Refined modes; one that could not be refined is kept as it came.

    Parameters
    ----------
    modes : ModeSet
        In the order of the modes given.
    outcomes : tuple of Outcome
        One per mode.
    misfit : (n_modes,) array
        Mean square of the whitened residual of the mode's band, 1 expected; NaN where not fitted.
    """

    modes: ModeSet
    outcomes: tuple[Outcome, ...]
    misfit: NDArray[np.float64]

    @property
    def n_refined(self) -> int:
        """How many modes were refined."""
        return sum(outcome is Outcome.REFINED for outcome in self.outcomes)


@dataclass(frozen=True, slots=True)
class _GroupFit:
    group: list[int]
    band: ReducedBand | None
    fit: BandFit | None


def refine(
    samples: Samples,
    modes: ModeSet,
    harmonics: ModeSet | None = None,
    largest_misfit: float = LARGEST_MISFIT,
    resting: Collection[int] = (),
) -> Refinement:
    """Refine modes by maximising the Whittle likelihood of the samples.

    Parameters
    ----------
    samples : Samples
        What the modes were identified from.
    modes : ModeSet
        Near the truth, all modes of the band: one that is missing biases those it overlaps.
    harmonics : ModeSet or None
        Lines whose frequencies are left out.
    largest_misfit : float
        Bands that the first pass describes worse get no second one.
    resting : collection of int
        Modes, by position, that shall not be refined; a band with one of them is not fitted.

    Returns
    -------
    Refinement
        Standard deviations from the Fisher information.

    Raises
    ------
    LayoutError
        The modes are of other channels than the samples.

    References
    ----------
    Au (2017), doi:10.1007/978-981-10-4118-1, chapters 10 and 12; limits of the scatter: Au (2014),
    doi:10.1016/j.ymssp.2013.12.016.
    """
    if modes.channel_names != samples.channel_names:
        raise LayoutError(
            'modes and samples are of different channels',
            found=', '.join(modes.channel_names),
            expected=', '.join(samples.channel_names),
        )
    order = sorted(
        (index for index, mode in enumerate(modes) if _refinable(mode)),
        key=lambda index: modes.modes[index].frequency_hz,
    )
    if not order:
        outcomes = (Outcome.OUT_OF_BAND,) * len(modes)
        return Refinement(modes, outcomes, np.full(len(modes), np.nan))
    with one_thread():
        return _refine_ordered(samples, modes, order, harmonics, largest_misfit, resting)


def _refinable(mode: Mode) -> bool:
    return not mode.harmonic and 1e-4 < mode.damping_ratio < 0.5


def _refine_ordered(
    samples: Samples,
    modes: ModeSet,
    order: list[int],
    harmonics: ModeSet | None,
    largest_misfit: float,
    resting: Collection[int],
) -> Refinement:
    """Fit the groups of modes, twice, and judge each mode."""
    spectra = _spectra(samples)
    usable = _usable(spectra, samples.sample_rate_hz, harmonics)
    alive = np.flatnonzero(samples.acceleration.std(axis=0) > 0.0)
    live = Spectra(spectra.frequency_hz, spectra.values[:, alive])
    given = [modes.modes[index] for index in order]
    start = StartModes(
        np.array([mode.frequency_hz for mode in given]),
        np.array([mode.damping_ratio for mode in given]),
        np.column_stack([_unit(mode.shape[alive]) for mode in given]),
    )
    now = with_unlisted(live, start, usable)
    groups, fits = group_modes(now), list[_GroupFit]()
    idle = {mode for mode, index in enumerate(order) if index in resting}
    n_unlisted = len(now.frequency_hz) - len(given)
    slopes = [SlopePrior()] * len(groups)
    n_passes = PASSES + (n_unlisted > 0)
    for number in range(n_passes):
        last_fits = fits if number == n_passes - 1 else []
        bad = {index for index, each in enumerate(last_fits) if _bad(each, largest_misfit)}
        fits = [
            _GroupFit(group, None, None)
            if not idle.isdisjoint(group)
            else fits[index]
            if index in bad
            else _fit_group(live, now, group, usable, slope)
            for index, (group, slope) in enumerate(zip(groups, slopes, strict=True))
        ]
        now = _updated(now, fits)
        slopes = _pooled_slopes(fits)
    result, outcomes = list(modes.modes), [Outcome.OUT_OF_BAND] * len(modes)
    misfit = np.full(len(modes), np.nan)
    for each in fits:
        for position, mode in enumerate(each.group):
            if mode >= len(given):
                continue
            index = order[mode]
            outcomes[index] = (
                Outcome.NOT_TRIED
                if not idle.isdisjoint(each.group)
                else _judge(each, position, given[mode], start, mode, samples.duration_s)
            )
            if each.fit is not None:
                misfit[index] = each.fit.misfit
            if outcomes[index] is Outcome.REFINED:
                result[index] = _refined(given[mode], each, position, now.shapes[:, mode], alive)
    return Refinement(replace(modes, modes=tuple(result)), tuple(outcomes), misfit)


def _spectra(samples: Samples) -> Spectra:
    data = samples.acceleration
    length = _fast_length(len(data))
    time = np.arange(len(data)) - 0.5 * (len(data) - 1)
    line = np.stack([np.ones(len(data)), time / np.linalg.norm(time)], axis=1)
    fit = (line.T @ data) / np.array([[len(data)], [1.0]])
    values = rfft(data[:length] - line[:length] @ fit, axis=0)
    values *= 1.0 / math.sqrt(length)
    return Spectra(np.arange(len(values)) * samples.sample_rate_hz / length, values)


def _fast_length(n_samples: int) -> int:
    """Return a length at most 0.5 % shorter that the transform likes; padding would correlate."""
    best = n_samples
    for shorter in range(n_samples, n_samples - max(1, n_samples // 200), -1):
        if next_fast_len(shorter, real=True) == shorter:
            return shorter
    return best


def _usable(
    spectra: Spectra, sample_rate_hz: float, harmonics: ModeSet | None
) -> NDArray[np.bool_]:
    frequency = spectra.frequency_hz
    usable = (frequency > 0.0) & (frequency <= HIGHEST_SHARE * sample_rate_hz)
    for line in harmonics or ():
        reach = LINE_REACH * spectra.spacing_hz
        usable &= np.abs(frequency - line.frequency_hz) > reach
    return np.asarray(usable)


def _unit(shape: NDArray[np.complex128]) -> NDArray[np.complex128]:
    length = np.linalg.norm(shape)
    return np.asarray(shape / length) if length > 0.0 else np.ones(len(shape), dtype=complex)


def _fit_group(
    spectra: Spectra,
    start: StartModes,
    group: list[int],
    usable: NDArray[np.bool_],
    slope: SlopePrior,
) -> _GroupFit:
    lines = band_lines(spectra, start, group, usable)
    if len(lines) < LEAST_LINES_PER_MODE * len(group):
        return _GroupFit(group, None, None)
    band = reduce_band(spectra, start, group, lines, slope)
    return _GroupFit(group, band, fit_band(band.data, band.model))


def _bad(each: _GroupFit, largest_misfit: float) -> bool:
    return each.fit is not None and each.fit.misfit > largest_misfit


def _pooled_slopes(fits: list[_GroupFit]) -> list[SlopePrior]:
    """Return for each band what the slopes of the others say about its own.

    The slope of the force density changes slowly over the logarithm of frequency; one band alone
    knows it badly, and guessing it costs information on the frequencies.  Gaussian process
    regression, each band left out in turn.
    """
    known = [each.fit for each in fits if each.fit is not None and each.fit.converged]
    if len(known) < 2:
        return [SlopePrior()] * len(fits)
    place = np.log([fit.model.reference_hz for fit in known])
    value = np.array([fit.model.slope for fit in known])
    # The fits were drawn towards the prior they had; undo that.
    first = np.array([fit.model.slope_prior.std for fit in known])
    precision = np.maximum(np.array([fit.slope_std for fit in known]) ** -2.0 - first**-2.0, 1e-3)
    value = value * (precision + first**-2.0) / precision
    kernel = SLOPE_STD**2 * np.exp(-0.5 * (np.subtract.outer(place, place) / SLOPE_REACH) ** 2)
    pooled = []
    for each in fits:
        if each.fit is None:
            pooled.append(SlopePrior())
            continue
        others = [index for index, fit in enumerate(known) if fit is not each.fit]
        cross = SLOPE_STD**2 * np.exp(
            -0.5 * ((np.log(each.fit.model.reference_hz) - place[others]) / SLOPE_REACH) ** 2
        )
        noisy = kernel[np.ix_(others, others)] + np.diag(1.0 / precision[others])
        weight = np.linalg.solve(noisy, cross)
        std = math.sqrt(max(SLOPE_STD**2 - float(weight @ cross), 1e-4))
        pooled.append(SlopePrior(float(weight @ value[others]), std))
    return pooled


def _updated(start: StartModes, fits: list[_GroupFit]) -> StartModes:
    """Return the modes after one pass; groups that did not converge stay."""
    frequency, damping = start.frequency_hz.copy(), start.damping_ratio.copy()
    shapes = start.shapes.copy()
    for each in fits:
        if each.fit is None or each.band is None or not each.fit.converged:
            continue
        count = len(each.group)
        frequency[each.group] = each.fit.model.frequency_hz[:count]
        damping[each.group] = each.fit.model.damping_ratio[:count]
        for position, mode in enumerate(each.group):
            new = each.fit.model.shapes[:, position]
            shapes[:, mode] = _whole_shape(each.band, new, start.shapes[:, mode])
    return StartModes(frequency, damping, shapes)


def _whole_shape(
    band: ReducedBand, new: NDArray[np.complex128], old: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Return the refined shape, with the old one's part that was projected out."""
    factor = np.vdot(new, band.project.T @ old)  # the new shape is of unit length
    return _unit(band.projected_out @ old + band.back @ (factor * new))


def _judge(
    each: _GroupFit, position: int, given: Mode, start: StartModes, mode: int, duration_s: float
) -> Outcome:
    if each.fit is None or each.band is None:
        return Outcome.TOO_SHORT
    if not each.fit.converged:
        return Outcome.NOT_CONVERGED
    if not each.fit.misfit < LARGEST_MISFIT:
        return Outcome.MODEL_MISFIT
    model = each.fit.model
    frequency, damping = model.frequency_hz[position], model.damping_ratio[position]
    law = math.sqrt(damping / (2.0 * math.pi * frequency * duration_s))
    frequency_std = _known(given.frequency_std_hz, 1.5 * law * frequency)
    damping_std = _known(given.damping_ratio_std, 1.5 * law)  # σ_ζ = sqrt(ζ/(2πfT)) is the same
    far = abs(frequency - given.frequency_hz) > FAR * math.hypot(
        frequency_std, each.fit.frequency_std[position] * frequency
    )
    far |= abs(damping - given.damping_ratio) > FAR * math.hypot(
        damping_std, each.fit.damping_ratio_std[position] * damping
    )
    before = each.band.project.T @ start.shapes[:, mode]
    far |= bool(mac(before, model.shapes[:, position])[0, 0] < LEAST_MAC)
    return Outcome.FAR_FROM_START if far else Outcome.REFINED


def _known(value: float, otherwise: float) -> float:
    return max(value, otherwise) if math.isfinite(value) else otherwise


def _refined(
    given: Mode,
    each: _GroupFit,
    position: int,
    shape: NDArray[np.complex128],
    alive: NDArray[np.intp],
) -> Mode:
    if each.fit is None or each.band is None:
        return given
    fit, band = each.fit, each.band
    frequency = float(fit.model.frequency_hz[position])
    damping = float(fit.model.damping_ratio[position])
    factor = np.vdot(fit.model.shapes[:, position], band.project.T @ shape)
    scatter = band.back @ (factor * fit.shape_scatter[position])
    whole = np.zeros(len(given.shape), dtype=complex)
    whole[alive] = shape
    whole = normalise(whole)
    std = np.zeros(len(given.shape), dtype=complex)
    std[alive] = normalised_std(shape, scatter)
    return replace(
        given,
        frequency_hz=frequency,
        damping_ratio=damping,
        shape=whole,
        # Few combinations of many channels say nothing about what they leave out.
        shape_std=std if band.is_whole and np.isfinite(std).all() else None,
        frequency_std_hz=float(fit.frequency_std[position]) * frequency,
        damping_ratio_std=float(fit.damping_ratio_std[position]) * damping,
        mpc=float(mpc(whole[:, None])[0]),
        mpd=float(mpd(whole[:, None])[0]),
    )
