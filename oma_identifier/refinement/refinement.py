"""Refine identified modes by maximum likelihood, all modes that overlap at once.

Subspace methods use the data well but not fully: their scatter is about one and a half times what
any method must have.  Starting from their modes, the likelihood of the spectra around each group
of modes is maximised; the result scatters near the limit and its standard deviations come from
the Fisher information.
"""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import LayoutError
from modal_core.free_memory import give_back, LARGE_BYTES
from modal_core.indicators import mpc, mpd, normalise
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.likelihood import (
    ForceSlope,
    group_modes,
    GroupFit,
    MacLoss,
    moving_channels,
    normalised_std,
    pooled_slopes,
    spectra_of,
    StartModes,
    unit,
    updated,
    usable_lines,
)
from oma_identifier.one_thread import one_thread
from oma_identifier.refinement.band_fitter import BandFitter, middle, slopes_of
from oma_identifier.refinement.completion import completed
from oma_identifier.refinement.foregoing import Foregoing, RefinedMode
from oma_identifier.refinement.mode_evidence import is_demanded, superfluous
from oma_identifier.refinement.unlisted import with_unlisted
from oma_identifier.refinement.verdict import judged, Outcome, overlap
from oma_identifier.refinement.whole_shapes import WholeShapes

PASSES = 2
"""The second pass has refined tails and shapes to project out."""


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
    with one_thread():
        return _refine_ordered(samples, modes, order, harmonics, resting, foregoing)


def _unrefined(modes: ModeSet) -> Refinement:
    outcomes = (Outcome.OUT_OF_BAND,) * len(modes)
    return Refinement(modes, outcomes, np.full(len(modes), np.nan), refined=(None,) * len(modes))


def _refinable(mode: Mode) -> bool:
    return not mode.harmonic and 1e-4 < mode.damping_ratio < 0.5


def _refine_ordered(
    samples: Samples,
    modes: ModeSet,
    order: list[int],
    harmonics: ModeSet | None,
    resting: Collection[int],
    foregoing: Foregoing | None,
) -> Refinement:
    """Fit the groups of modes, twice, and judge each mode."""
    if not order:  # from the start, or since the fits have taken out the last one
        return _unrefined(modes)
    alive = moving_channels(samples)
    spectra = spectra_of(samples, alive)
    if spectra.values.nbytes >= LARGE_BYTES:
        give_back()
    usable = usable_lines(spectra, harmonics or ())
    given = [modes.modes[index] for index in order]
    start = StartModes(
        np.array([mode.frequency_hz for mode in given]),
        np.array([mode.damping_ratio for mode in given]),
        np.column_stack([unit(mode.shape[alive]) for mode in given]),
    )
    idle = {mode for mode, index in enumerate(order) if index in resting}
    fitter = BandFitter(spectra, usable, idle)
    known = None if foregoing is None else foregoing.start(given, start, alive, idle)
    now = with_unlisted(spectra, start if known is None else known.modes, usable)
    groups = group_modes(now)
    if known is not None and foregoing is not None:
        slopes = pooled_slopes(foregoing.slopes, [middle(now, group) for group in groups])
        fits = fitter.fit(now, groups, slopes, begin=known.begin)
    else:
        fits = fitter.fit(now, groups)
    twice = [each.group[at] for each in fits if (at := superfluous(each)) is not None]
    if twice and twice[0] < len(given):
        rest = [index for mode, index in enumerate(order) if mode != twice[0]]
        found = _refine_ordered(samples, modes, rest, harmonics, resting, foregoing)
        outcomes = list(found.outcomes)
        outcomes[order[twice[0]]] = Outcome.SUPERFLUOUS
        return replace(found, outcomes=tuple(outcomes))
    now = updated(now, fits)
    n_passes = PASSES - (known is not None) + (len(now.frequency_hz) > len(given))
    for _ in range(1, n_passes):
        now, fits = fitter.again(now, fits)
    now, fits, demanded = completed(fitter, now, fits, start)
    result, outcomes = list(modes.modes), [Outcome.OUT_OF_BAND] * len(modes)
    misfit = np.full(len(modes), np.nan)
    refined: list[RefinedMode | None] = [None] * len(modes)
    shapes = WholeShapes(spectra, now)
    added, added_misfit = list[Mode](), list[float]()
    for each in fits:
        for position, mode in enumerate(each.group):
            if mode >= len(given):
                continue
            index = order[mode]
            split = [other for other in demanded if overlap(now, mode, other)]
            if not idle.isdisjoint(each.group):
                outcomes[index] = Outcome.NOT_TRIED
            elif split and is_demanded(each, position):
                outcomes[index] = Outcome.SPLIT
            else:
                outcomes[index] = judged(
                    each, position, given[mode], start, mode, samples.duration_s
                )
            misfit[index] = each.misfit
            if outcomes[index] in (Outcome.REFINED, Outcome.SPLIT):
                result[index] = _refined(given[mode], each, position, shapes, alive)
                refined[index] = RefinedMode(result[index], each, position)
    blank = Mode(math.nan, math.nan, np.zeros(samples.acceleration.shape[1], dtype=complex))
    for mode, each in demanded.items():
        position = each.group.index(mode)
        added.append(_refined(blank, each, position, shapes, alive))
        added_misfit.append(each.misfit)
    return Refinement(
        replace(modes, modes=tuple(result)),
        tuple(outcomes),
        misfit,
        tuple(added),
        np.array(added_misfit),
        alive,
        tuple(refined),
        tuple(slopes_of(fits)),
    )


def _refined(
    given: Mode,
    each: GroupFit,
    position: int,
    shapes: WholeShapes,
    alive: NDArray[np.intp],
) -> Mode:
    if each.fit is None:
        return given
    fit, estimate = each.fit, shapes.of(each, position)
    frequency = float(fit.model.frequency_hz[position])
    damping = float(fit.model.damping_ratio[position])
    whole, std = np.zeros((2, len(given.shape)), dtype=complex)
    whole[alive], std[alive] = estimate.shape, normalised_std(estimate.shape, estimate.scatter)
    whole = normalise(whole)
    loss = MacLoss.of(estimate.shape, estimate.scatter)
    return replace(
        given,
        frequency_hz=frequency,
        damping_ratio=damping,
        shape=whole,
        shape_std=std if np.isfinite(std).all() else None,
        mac_loss=loss.mean,
        mac_loss_std=loss.std,
        frequency_std_hz=float(fit.frequency_std[position]) * frequency,
        damping_ratio_std=float(fit.damping_ratio_std[position]) * damping,
        mpc=float(mpc(whole[:, None])[0]),
        mpd=float(mpd(whole[:, None])[0]),
    )
