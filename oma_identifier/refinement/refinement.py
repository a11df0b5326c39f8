"""Refine identified modes by maximum likelihood, all modes that overlap at once.

Subspace methods use the data well but not fully: their scatter is about one and a half times what
any method must have.  Starting from their modes, the likelihood of the spectra around each group
of modes is maximised; the result scatters near the limit and its standard deviations come from
the Fisher information.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import LayoutError
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mpc, mpd, normalise
from modal_core.samples import Samples
from oma_identifier.likelihood import (
    BandIndex,
    ForceCourse,
    GroupFit,
    MacLoss,
    normalised_std,
)
from oma_identifier.one_thread import one_thread
from oma_identifier.refinement.acceptance import Outcome, TAKEN
from oma_identifier.refinement.narrow_force import NarrowForce
from oma_identifier.refinement.refining import GivenIndex, is_refinable, Record, Refining
from oma_identifier.refinement.stages import STAGES
from oma_identifier.refinement.warm_start import RefinedMode, WarmStart
from oma_identifier.refinement.whole_shapes import WholeShapes


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
    narrow : tuple of NarrowForce
        Forces that were taken for modes.
    """

    modes: ModeSet
    outcomes: tuple[Outcome, ...]
    misfit: NDArray[np.float64]
    added: tuple[Mode, ...] = ()
    added_misfit: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    channels: NDArray[np.intp] = field(default_factory=lambda: np.empty(0, dtype=np.intp))
    refined: tuple[RefinedMode | None, ...] = ()
    narrow: tuple[NarrowForce, ...] = ()

    @property
    def without_forces(self) -> 'Refinement':
        """The same where what ends may be a mode that moves."""
        outcomes = tuple(
            Outcome.MODEL_MISFIT if each is Outcome.NARROW_FORCE else each
            for each in self.outcomes
        )
        return replace(self, outcomes=outcomes, narrow=())


def refine(
    samples: Samples,
    modes: ModeSet,
    harmonics: ModeSet | None = None,
    resting: Collection[int] = (),
    warm_start: WarmStart | None = None,
    more: Sequence[Samples] = (),
    candidates: Sequence[Mode] = (),
    *,
    is_whole: bool = False,
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
    warm_start : WarmStart or None
        What another stretch of the same structure told: where all modes agree with it the fits
        start there, and one pass is enough.
    more : sequence of Samples
        Further stretches of the same channels and rate, between gaps.
    candidates : sequence of Mode
        What may be modes that are missing.
    is_whole : bool
        Whether the samples are a record as one, and no window.

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
    given = sorted(
        (GivenIndex(index) for index, mode in enumerate(modes) if is_refinable(mode)),
        key=lambda index: modes.modes[index].frequency_hz,
    )
    if not given:
        return _unrefined(modes)
    with one_thread():
        record = Record.of(
            samples, modes, harmonics, resting, warm_start, more, candidates, is_whole
        )
        of = Refining.begin(record, given)
        for stage in STAGES:
            of = stage(of)
        return _refinement(of)


def _unrefined(modes: ModeSet) -> Refinement:
    outcomes = (Outcome.OUT_OF_BAND,) * len(modes)
    return Refinement(modes, outcomes, np.full(len(modes), np.nan), refined=(None,) * len(modes))


def _refinement(of: Refining) -> Refinement:
    """Return the modes after the last stage, in the order in which they were given."""
    record = of.record
    modes, misfit = list(record.modes), np.full(len(record.modes), np.nan)
    refined: list[RefinedMode | None] = [None] * len(modes)
    shapes = WholeShapes(record.spectra, of.now)
    course = ForceCourse.of(record.spectra, of.fits)
    for each in of.fits:
        for position, mode in each.members():
            if mode >= of.n_given:
                continue
            index = of.given[mode]
            misfit[index] = each.misfit
            if of.outcomes[index] in TAKEN:
                modes[index] = _refined(modes[index], each, position, shapes, record, course)
                # The next window's fits begin without known inputs.
                refined[index] = RefinedMode(modes[index], each.without or each, position)
    blank = Mode(math.nan, math.nan, np.zeros(len(record.modes.channel_names), dtype=complex))
    return Refinement(
        replace(record.modes, modes=tuple(modes)),
        tuple(
            of.outcomes.get(GivenIndex(index), Outcome.OUT_OF_BAND) for index in range(len(modes))
        ),
        misfit,
        tuple(
            _refined(blank, each, each.position(mode), shapes, record, course)
            for mode, each in of.added.items()
        ),
        np.array([each.misfit for each in of.added.values()]),
        record.channels,
        tuple(refined),
        of.narrow,
    )


def _refined(
    given: Mode,
    each: GroupFit,
    position: BandIndex,
    shapes: WholeShapes,
    record: Record,
    course: ForceCourse,
) -> Mode:
    if each.fit is None:
        return given
    fit, estimate = each.fit, shapes.of(each, position)
    frequency = float(fit.model.frequency_hz[position])
    damping = float(fit.model.damping_ratio[position])
    wider = course.widening(damping * frequency)
    alive, scatter = record.channels, wider * estimate.scatter
    whole, std = np.zeros((2, len(given.shape)), dtype=complex)
    whole[alive], std[alive] = estimate.shape, normalised_std(estimate.shape, scatter)
    whole = normalise(whole)
    loss = MacLoss.of(estimate.shape, scatter)
    return replace(
        given,
        frequency_hz=frequency,
        damping_ratio=damping,
        shape=whole,
        shape_std=std if np.isfinite(std).all() else None,
        mac_loss=loss.mean,
        mac_loss_std=loss.std,
        frequency_std_hz=wider * float(fit.frequency_std[position]) * frequency,
        damping_ratio_std=wider * float(fit.damping_ratio_std[position]) * damping,
        mpc=float(mpc(whole[:, None])[0]),
        mpd=float(mpd(whole[:, None])[0]),
        known_motion=each.band is not None and each.band.motion is not None,
    )
