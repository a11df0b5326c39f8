"""Refine identified modes by maximum likelihood, all modes that overlap at once.

Subspace methods use the data well but not fully: their scatter is about one and a half times what
any method must have.  Starting from their modes, the likelihood of the spectra around each group
of modes is maximised; the result scatters near the limit and its standard deviations come from
the Fisher information.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import LayoutError
from modal_core.indicators import mpc, mpd, normalise
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.band_data import group_modes, ReducedBand, StartModes
from oma_identifier.continued import continued
from oma_identifier.force_slopes import ForceSlope, pooled_slopes
from oma_identifier.foregoing import Foregoing, RefinedMode
from oma_identifier.group_fits import fit_group, GroupFit, unit, updated
from oma_identifier.line_spectra import moving_channels, Spectra, spectra_of, usable_lines
from oma_identifier.mode_evidence import is_demanded, missing_mode, MissingMode, superfluous
from oma_identifier.one_thread import one_thread
from oma_identifier.shape_scatter import normalised_std
from oma_identifier.unlisted import with_unlisted
from oma_identifier.whittle import BandModel, IMPATIENT, Patience, PATIENT, SlopePrior

PASSES = 2
"""The second pass has refined tails and shapes to project out."""
FAR = 5.0
"""Standard deviations a refined mode may be away from its start."""
LEAST_MAC = 0.8
LARGEST_MISFIT = 3.0
INCOMPLETE_MISFIT = 1.5
"""From here on a band may lack a mode."""
MOST_MISSING = 2


class Outcome(StrEnum):
    """What became of one mode."""

    REFINED = 'refined'
    SPLIT = 'split'
    """Refined, and another mode was found that it stood for as well."""
    SUPERFLUOUS = 'superfluous'
    """Another mode once more: the data do without it."""
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
        Mean square of the whitened residual of the mode's band, 1 expected, less what chance may
        add; NaN where not fitted.
    added : tuple of Mode
        Modes that were not given and that the data demand.
    added_misfit : (n_added,) array
        As ``misfit``.
    channels : (n_alive,) int array
        That are not dead.
    refined : tuple of RefinedMode or None
        One per mode given, None where it was not refined.
    slopes : tuple of ForceSlope
        Of the bands that were fitted.
    """

    modes: ModeSet
    outcomes: tuple[Outcome, ...]
    misfit: NDArray[np.float64]
    added: tuple[Mode, ...] = ()
    added_misfit: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    channels: NDArray[np.intp] = field(default_factory=lambda: np.empty(0, dtype=np.intp))
    refined: tuple[RefinedMode | None, ...] = ()
    slopes: tuple[ForceSlope, ...] = ()

    @property
    def n_refined(self) -> int:
        """How many modes were refined."""
        return sum(outcome in (Outcome.REFINED, Outcome.SPLIT) for outcome in self.outcomes)


def refine(
    samples: Samples,
    modes: ModeSet,
    harmonics: ModeSet | None = None,
    largest_misfit: float = LARGEST_MISFIT,
    resting: Collection[int] = (),
    foregoing: Foregoing | None = None,
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
    foregoing : Foregoing or None
        What another stretch of the same structure told: where all modes agree with it the fits
        start there, and one pass is enough.

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
        return Refinement(
            modes, outcomes, np.full(len(modes), np.nan), refined=(None,) * len(modes)
        )
    with one_thread():
        return _refine_ordered(
            samples, modes, order, harmonics, largest_misfit, resting, foregoing
        )


def _refinable(mode: Mode) -> bool:
    return not mode.harmonic and 1e-4 < mode.damping_ratio < 0.5


def _refine_ordered(
    samples: Samples,
    modes: ModeSet,
    order: list[int],
    harmonics: ModeSet | None,
    largest_misfit: float,
    resting: Collection[int],
    foregoing: Foregoing | None,
) -> Refinement:
    """Fit the groups of modes, twice, and judge each mode."""
    alive = moving_channels(samples)
    spectra = spectra_of(samples, alive)
    usable = usable_lines(spectra, harmonics or ())
    given = [modes.modes[index] for index in order]
    start = StartModes(
        np.array([mode.frequency_hz for mode in given]),
        np.array([mode.damping_ratio for mode in given]),
        np.column_stack([unit(mode.shape[alive]) for mode in given]),
    )
    idle = {mode for mode, index in enumerate(order) if index in resting}
    fitter = _Fitter(spectra, usable, idle)
    known = None if foregoing is None else foregoing.start(given, start, alive, idle)
    now = with_unlisted(spectra, start if known is None else known.modes, usable)
    groups = group_modes(now)
    if known is not None and foregoing is not None:
        slopes = pooled_slopes(foregoing.slopes, [_middle(now, group) for group in groups])
        fits = fitter.fit(now, groups, slopes, begin=known.begin)
    else:
        fits = fitter.fit(now, groups)
    twice = [each.group[at] for each in fits if (at := superfluous(each)) is not None]
    if twice and twice[0] < len(given):
        rest = [index for mode, index in enumerate(order) if mode != twice[0]]
        found = _refine_ordered(
            samples, modes, rest, harmonics, largest_misfit, resting, foregoing
        )
        outcomes = list(found.outcomes)
        outcomes[order[twice[0]]] = Outcome.SUPERFLUOUS
        return replace(found, outcomes=tuple(outcomes))
    now = updated(now, fits)
    n_passes = PASSES - (known is not None) + (len(now.frequency_hz) > len(given))
    for number in range(1, n_passes):
        last = number == n_passes - 1
        bad = [each for each in fits if last and each.misfit > largest_misfit]
        now, fits = fitter.again(now, fits, bad)
    now, fits, demanded = _completed(fitter, now, fits, len(given))
    result, outcomes = list(modes.modes), [Outcome.OUT_OF_BAND] * len(modes)
    misfit = np.full(len(modes), np.nan)
    refined: list[RefinedMode | None] = [None] * len(modes)
    added, added_misfit = list[Mode](), list[float]()
    for each in fits:
        for position, mode in enumerate(each.group):
            if mode >= len(given):
                continue
            index = order[mode]
            split = [other for other in demanded if _overlap(now, mode, other)]
            if not idle.isdisjoint(each.group):
                outcomes[index] = Outcome.NOT_TRIED
            elif split and is_demanded(each, position):
                outcomes[index] = Outcome.SPLIT
            else:
                outcomes[index] = _judge(
                    each, position, given[mode], start, mode, samples.duration_s
                )
            misfit[index] = each.misfit
            if outcomes[index] in (Outcome.REFINED, Outcome.SPLIT):
                result[index] = _refined(given[mode], each, position, now.shapes[:, mode], alive)
                refined[index] = RefinedMode(result[index], each, position)
    blank = Mode(math.nan, math.nan, np.zeros(samples.acceleration.shape[1], dtype=complex))
    for mode, each in demanded.items():
        position = each.group.index(mode)
        added.append(_refined(blank, each, position, now.shapes[:, mode], alive))
        added_misfit.append(each.misfit)
    return Refinement(
        replace(modes, modes=tuple(result)),
        tuple(outcomes),
        misfit,
        tuple(added),
        np.array(added_misfit),
        alive,
        tuple(refined),
        tuple(_slopes(fits)),
    )


@dataclass(frozen=True, slots=True)
class _Fitter:
    """What the fits of one record share; groups with an idle mode are not fitted."""

    spectra: Spectra
    usable: NDArray[np.bool_]
    idle: Collection[int]

    def fit(
        self,
        now: StartModes,
        groups: Sequence[list[int]],
        slopes: Sequence[SlopePrior] | None = None,
        known: Sequence[GroupFit] = (),
        patience: Patience = PATIENT,
        begin: Callable[[ReducedBand], BandModel | None] = lambda _: None,
    ) -> list[GroupFit]:
        """Fit every group but those whose fit is known."""
        done = {tuple(each.group): each for each in known}
        return [
            done.get(tuple(group)) or self._one(now, group, slope, patience, begin)
            for group, slope in zip(groups, slopes or [SlopePrior()] * len(groups), strict=True)
        ]

    def again(
        self, now: StartModes, fits: Sequence[GroupFit], known: Sequence[GroupFit] = ()
    ) -> tuple[StartModes, list[GroupFit]]:
        """Fit the same groups once more, with what the others say about slopes."""
        groups = [each.group for each in fits]
        places = [math.nan if each.fit is None else _middle(now, each.group) for each in fits]
        before = {each.group[0]: each for each in fits}
        same = {mode: mode for mode in range(len(now.frequency_hz))}
        fits = self.fit(
            now,
            groups,
            pooled_slopes(_slopes(fits), places),
            known,
            IMPATIENT,
            lambda band: continued(band, before.get(band.included[0]), same),
        )
        return updated(now, fits), fits

    def _one(
        self,
        now: StartModes,
        group: list[int],
        slope: SlopePrior,
        patience: Patience,
        begin: Callable[[ReducedBand], BandModel | None],
    ) -> GroupFit:
        if any(mode in self.idle for mode in group):
            return GroupFit(group)
        return fit_group(self.spectra, now, group, self.usable, slope, patience, begin)


def _slopes(fits: Sequence[GroupFit]) -> list[ForceSlope]:
    return [ForceSlope.of(each.fit) for each in fits if each.fit and each.fit.converged]


def _middle(now: StartModes, group: list[int]) -> float:
    """Return ln f in the middle of a group."""
    return float(np.mean(np.log(now.frequency_hz[group])))


def _completed(
    fitter: _Fitter, now: StartModes, fits: list[GroupFit], n_given: int
) -> tuple[StartModes, list[GroupFit], dict[int, GroupFit]]:
    """Add modes that are missing, one by one, as long as that mends the bands that lack one.

    Returns
    -------
    tuple
        The modes, their fits, and those beyond the given ones that the data demand.
    """
    before = now, fits
    for _ in range(MOST_MISSING):
        lacking = [each for each in fits if INCOMPLETE_MISFIT < each.misfit < math.inf]
        found = [(mode, each) for each in lacking if (mode := missing_mode(each)) is not None]
        if not found:
            break
        mode, source = max(found, key=lambda pair: pair[0].rise)
        wider = _appended(now, mode)
        groups = group_modes(wider)
        own = next(group for group in groups if len(now.frequency_hz) in group)
        # The other bands matter only once the mode's own is mended.
        (mended,) = fitter.fit(wider, [own], patience=IMPATIENT)
        if mended.fit is None or not mended.fit.converged or not mended.misfit < source.misfit:
            break
        good = [each for each in fits if each.misfit <= INCOMPLETE_MISFIT]
        more = fitter.fit(wider, groups, known=[*good, mended], patience=IMPATIENT)
        now, fits = updated(wider, more), more
    if fits is not before[1]:
        now, fits = fitter.again(now, fits)
    demanded = _demanded(fits, n_given)
    if not any(mode >= len(before[0].frequency_hz) for mode in demanded):
        return *before, _demanded(before[1], n_given)
    return now, fits, demanded


def _demanded(fits: Sequence[GroupFit], n_given: int) -> dict[int, GroupFit]:
    return {
        mode: each
        for each in fits
        for position, mode in enumerate(each.group)
        if mode >= n_given and each.misfit < LARGEST_MISFIT and is_demanded(each, position)
    }


def _appended(now: StartModes, mode: MissingMode) -> StartModes:
    return StartModes(
        np.append(now.frequency_hz, mode.frequency_hz),
        np.append(now.damping_ratio, mode.damping_ratio),
        np.column_stack([now.shapes, mode.shape]),
    )


def _judge(
    each: GroupFit, position: int, given: Mode, start: StartModes, mode: int, duration_s: float
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
    # Modes that overlap may be mixed at the start, so the shape may turn towards its neighbours'.
    listed = range(len(start.frequency_hz))
    near = [other for other in each.group if other in listed and _overlap(start, mode, other)]
    before = np.linalg.qr(each.band.project.T @ start.shapes[:, near])[0]
    kept = np.linalg.norm(before.conj().T @ model.shapes[:, position])
    far |= bool(kept**2 < LEAST_MAC)
    return Outcome.FAR_FROM_START if far else Outcome.REFINED


def _overlap(start: StartModes, first: int, second: int) -> bool:
    apart = abs(start.frequency_hz[first] - start.frequency_hz[second])
    return bool(apart <= start.half_width_hz[first] + start.half_width_hz[second])


def _known(value: float, otherwise: float) -> float:
    return max(value, otherwise) if math.isfinite(value) else otherwise


def _refined(
    given: Mode,
    each: GroupFit,
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
