"""Takes over refined modes where the likelihood describes the data, and only there.

The refinement is more precise than the subspace estimate when its model holds: modes under forces
that are white around them.  Where the spectrum says otherwise, or where the two estimates differ
by more than their deviations allow (Hausman's test: an efficient against a consistent estimator),
the subspace estimate stands.  Modes that the likelihood finds missing are taken in.

References
----------
Hausman (1978), doi:10.2307/1913827.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import logging
import math

import numpy as np

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.likelihood import with_least_scatter
from oma_identifier.refinement.acceptance import Outcome, TAKEN
from oma_identifier.refinement.backoff import Backoff
from oma_identifier.refinement.narrow_force import NarrowForce
from oma_identifier.refinement.refinement import refine, Refinement
from oma_identifier.refinement.thresholds import REFINEMENT
from oma_identifier.refinement.told_apart import repeated
from oma_identifier.refinement.warm_start import WarmStart

NEW = -1
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Adopted:
    """Modes after refinement.

    Parameters
    ----------
    modes : ModeSet
        By frequency.
    origin : tuple of int
        Where each was in the modes given; NEW for one that the likelihood found missing.
    forced : tuple of int
        Modes given, by position, that are peaks of narrow-band forces.
    """

    modes: ModeSet
    origin: tuple[int, ...]
    forced: tuple[int, ...] = ()


def adopt_refined(
    samples: Samples,
    modes: ModeSet,
    harmonics: ModeSet,
    more: Sequence[Samples] = (),
    candidates: Sequence[Mode] = (),
    *,
    is_compared: bool = False,
) -> Adopted:
    """Return the modes, more precise where that is safe.

    Parameters
    ----------
    samples : Samples
        What the modes were identified from.
    modes, harmonics : ModeSet
        From the subspace identification.
    more : sequence of Samples
        Further stretches of the same channels and rate, between gaps.
    candidates : sequence of Mode
        What may be modes that are missing.
    is_compared : bool
        As for :class:`Refiner`.
    """
    return Refiner(is_whole=True, is_compared=is_compared).adopt(
        samples, modes, harmonics, more, candidates
    )


class Refiner:
    """Refines window after window.

    Where the model does not describe the spectrum, the modes are left as they are for a while
    (:class:`Backoff`).  Where it does, the refined modes of one window are where the next begins.

    Parameters
    ----------
    is_whole : bool
        Whether there is one window, a record as one.
    is_compared : bool
        Whether it is compared with other parts of a record, to tell whether modes move: then it
        is no less sure, and a mode that moves does not end as a force's.
    """

    def __init__(self, *, is_whole: bool = False, is_compared: bool = False) -> None:
        self._is_whole, self._is_compared = is_whole, is_compared
        self._backoff = Backoff()
        self._warm_start: WarmStart | None = None
        self._channel_names: tuple[str, ...] = ()

    def adopt(
        self,
        samples: Samples,
        modes: ModeSet,
        harmonics: ModeSet,
        more: Sequence[Samples] = (),
        candidates: Sequence[Mode] = (),
    ) -> Adopted:
        """Return the modes of a window, see :func:`adopt_refined`."""
        places = [self._backoff.at(mode.frequency_hz) for mode in modes]
        resting = {index for index, rest in enumerate(places) if rest is not None and rest.left}
        for index in sorted(resting):
            log.debug(
                '%.4g Hz: not refined, as in the windows before', modes.modes[index].frequency_hz
            )
        self._backoff.next_window()
        if len(resting) == len(modes):
            return _as_given(modes)
        if modes.channel_names != self._channel_names:
            self._warm_start, self._channel_names = None, modes.channel_names
        try:
            found = refine(
                samples,
                modes,
                harmonics,
                resting,
                self._warm_start,
                more,
                candidates,
                is_whole=self._is_whole,
            )
        except np.linalg.LinAlgError:
            log.debug('not refined: a matrix was singular')
            return _as_given(modes)
        if self._is_compared:
            found = found.without_forces
        taken = [
            _is_better(index, modes, found, 0.5 * samples.sample_rate_hz)
            for index in range(len(modes))
        ]
        for index, (mode, outcome) in enumerate(zip(modes, found.outcomes, strict=True)):
            if outcome not in (Outcome.SUPERFLUOUS, Outcome.NOT_TRIED):
                if found.misfit[index] <= REFINEMENT.hopeless_misfit:
                    self._backoff.succeeded(places[index])
                else:
                    self._backoff.failed(places[index], mode.frequency_hz)
        good = tuple(
            fit for fit, better in zip(found.refined, taken, strict=True) if better and fit
        )
        self._warm_start = WarmStart(found.channels, good)
        duration_s = samples.duration_s + sum(part.duration_s for part in more)
        return _adopted(self._in_doubt(modes, found, taken), found, taken, duration_s)

    def _in_doubt(self, modes: ModeSet, found: Refinement, taken: Sequence[bool]) -> ModeSet:
        """Return modes of a record as one that stay as they are, less sure where a fit differs.

        Windows are compared with each other, which tells more.
        """
        if not self._is_whole or self._is_compared:
            return modes
        kept = list(modes)
        for index, (plain, refined) in enumerate(zip(modes, found.modes, strict=True)):
            described = found.misfit[index] < REFINEMENT.incomplete_misfit
            if not taken[index] and found.outcomes[index] in TAKEN and described:
                kept[index] = _less_sure(plain, refined)
        return replace(modes, modes=tuple(kept))


def _as_given(modes: ModeSet) -> Adopted:
    return _without_repeated(modes, list(zip(modes, range(len(modes)), strict=True)))


def _adopted(
    modes: ModeSet, found: Refinement, taken: Sequence[bool], duration_s: float
) -> Adopted:
    """Return the modes given, the better ones replaced, with those that were missing."""
    adopted: list[tuple[Mode, int]] = []
    for index, (plain, refined) in enumerate(zip(modes, found.modes, strict=True)):
        if found.outcomes[index] in (Outcome.SUPERFLUOUS, Outcome.NARROW_FORCE):
            continue
        mode = plain
        if taken[index]:
            mode = with_least_scatter(_merged(plain, refined), duration_s)
        adopted.append((mode, index))
    for mode, misfit in zip(found.added, found.added_misfit, strict=True):
        if misfit <= REFINEMENT.adopted_misfit:
            adopted.append((with_least_scatter(mode, duration_s), NEW))
        else:
            log.debug('%.4g Hz: not taken in, misfit %.3g', mode.frequency_hz, misfit)
    adopted.sort(key=lambda each: each[0].frequency_hz)
    told = [(_told(mode, found.narrow), index) for mode, index in adopted]
    forced = [i for i, why in enumerate(found.outcomes) if why is Outcome.NARROW_FORCE]
    return replace(_without_repeated(modes, told), forced=tuple(forced))


def _told(mode: Mode, narrow: Sequence[NarrowForce]) -> Mode:
    """Return a mode without deviations where a narrow-band force reaches its bell."""
    half_width_hz = mode.damping_ratio * mode.frequency_hz
    if any(force.shakes(mode.frequency_hz, half_width_hz) for force in narrow):
        return mode.untold
    return mode


def _without_repeated(modes: ModeSet, adopted: Sequence[tuple[Mode, int]]) -> Adopted:
    left_out = repeated([mode for mode, _ in adopted])
    for place in sorted(left_out):
        log.debug('%.4g Hz: another mode once more', adopted[place][0].frequency_hz)
    kept = [each for place, each in enumerate(adopted) if place not in left_out]
    return Adopted(
        replace(modes, modes=tuple(mode for mode, _ in kept)),
        tuple(origin for _, origin in kept),
    )


def _is_better(index: int, modes: ModeSet, found: Refinement, end_hz: float) -> bool:
    """Tell whether a refined mode replaces the one given; log why not."""
    plain, refined = modes.modes[index], found.modes.modes[index]
    outcome, misfit = found.outcomes[index], found.misfit[index]
    if outcome not in TAKEN:
        return False
    if not misfit <= REFINEMENT.adopted_misfit:
        log.debug('%.4g Hz: kept as it was, misfit %.3g', plain.frequency_hz, misfit)
        return False
    beside = any(_is_beside(plain, other) for other in modes)
    bias = REFINEMENT.pair_bias if beside else 0.0
    alike = beside or is_alike(plain, refined)
    agree = _agree(plain, refined, bias + _beside_end(plain, end_hz))
    if len(modes.channel_names) == 1:
        agree = agree or _is_within(plain, refined)
    if outcome is Outcome.SPLIT or (agree and alike):
        return True
    log.debug(
        '%.4g Hz: kept as it was, refined to %.4g Hz and %.3g against %.3g of critical damping',
        plain.frequency_hz,
        refined.frequency_hz,
        refined.damping_ratio,
        plain.damping_ratio,
    )
    return False


def _is_beside(mode: Mode, other: Mode) -> bool:
    apart = abs(mode.frequency_hz - other.frequency_hz)
    width = mode.damping_ratio * mode.frequency_hz + other.damping_ratio * other.frequency_hz
    return other is not mode and apart < width


def _is_within(plain: Mode, refined: Mode) -> bool:
    """Tell whether a refined mode lies within the half-width of the plain one.

    In one channel the plain estimate is the wrong one where they differ there: mostly it is damped
    too little, by more than its deviation.  Farther apart they may be two maxima.
    """
    apart = abs(refined.frequency_hz - plain.frequency_hz)
    return apart < REFINEMENT.same_of_one_channel * plain.damping_ratio * plain.frequency_hz


def _beside_end(mode: Mode, end_hz: float) -> float:
    """Return the half-width of a mode over its distance to the end of the spectrum."""
    left_hz = max(end_hz - mode.frequency_hz, 1e-3 * end_hz)
    return mode.damping_ratio * mode.frequency_hz / left_hz


def is_alike(plain: Mode, refined: Mode) -> bool:
    """Tell whether a shape turned by no more than its own scatter and the plain one's explain."""
    turned = 1.0 - float(mac(plain.shape, refined.shape)[0, 0])
    return turned <= REFINEMENT.turn_bias + REFINEMENT.farthest_turn * refined.mac_loss


def _agree(plain: Mode, refined: Mode, bias: float) -> bool:
    """Tell whether the estimates differ by no more than chance and a bias in half-widths.

    False for a deviation of NaN.
    """
    f_step = plain.frequency_hz - refined.frequency_hz
    d_step = plain.damping_ratio - refined.damping_ratio
    bias *= plain.damping_ratio
    f_spread = _spread(plain.frequency_std_hz, refined.frequency_std_hz)
    f_spread = math.hypot(f_spread, bias * plain.frequency_hz)
    d_spread = math.hypot(_spread(plain.damping_ratio_std, refined.damping_ratio_std), bias)
    return (
        abs(f_step) <= REFINEMENT.differing_std * f_spread
        and abs(d_step) <= REFINEMENT.differing_std * d_spread
    )


def _spread(plain_std: float, refined_std: float) -> float:
    """Return √(var(plain) - var(refined)), the deviation of the difference, with a floor.

    Where both are almost as precise the bias of the plain estimate, which its deviation does not
    include, would decide.
    """
    return math.sqrt(
        max(plain_std**2 - refined_std**2, (REFINEMENT.least_spread * plain_std) ** 2)
    )


def _less_sure(plain: Mode, refined: Mode) -> Mode:
    """Return a plain estimate with what it and a refined one differ by beyond chance.

    Where both describe the data one is wrong, and nothing says which.  Of 54 modes with such fits,
    many of them beside narrow-band forces, 9 of 92 values were more than 3 deviations off before,
    4 after; deviations of 14 others of random families grew by 1 %.

    References
    ----------
    DerSimonian and Laird (1986), doi:10.1016/0197-2456(86)90046-2.
    """
    return replace(
        plain,
        frequency_std_hz=_beyond_chance(
            plain.frequency_hz - refined.frequency_hz,
            plain.frequency_std_hz,
            refined.frequency_std_hz,
        ),
        damping_ratio_std=_beyond_chance(
            plain.damping_ratio - refined.damping_ratio,
            plain.damping_ratio_std,
            refined.damping_ratio_std,
        ),
    )


def _beyond_chance(step: float, plain_std: float, refined_std: float) -> float:
    between = step**2 - _spread(plain_std, refined_std) ** 2
    # The first argument stands where it is NaN.
    return math.hypot(plain_std, math.sqrt(max(0.0, between)))


def _merged(plain: Mode, refined: Mode) -> Mode:
    return replace(
        plain,
        frequency_hz=refined.frequency_hz,
        frequency_std_hz=refined.frequency_std_hz,
        damping_ratio=refined.damping_ratio,
        damping_ratio_std=refined.damping_ratio_std,
        shape=refined.shape,
        shape_std=refined.shape_std,
        mac_loss=refined.mac_loss,
        mac_loss_std=refined.mac_loss_std,
        mpc=refined.mpc,
        mpd=refined.mpd,
        known_motion=refined.known_motion,
    )
