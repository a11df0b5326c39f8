"""Takes over refined modes where the likelihood describes the data, and only there.

The refinement is more precise than the subspace estimate when its model holds: modes under forces
that are white around them.  Where the spectrum says otherwise, or where the two estimates differ
by more than their deviations allow (Hausman's test: an efficient against a consistent estimator),
the subspace estimate stands.  Modes that the likelihood finds missing are taken in.

References
----------
Hausman (1978), doi:10.2307/1913827.
"""

from dataclasses import dataclass, replace
import math

import numpy as np

from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.refinement.foregoing import Foregoing, RefinedMode
from oma_identifier.refinement.refinement import refine
from oma_identifier.refinement.verdict import Outcome

LARGEST_MISFIT = 1.05
"""Mean square of the whitened residual; 1 where the model holds."""
HOPELESS_MISFIT = 1.15
"""From here on the next window will hardly be described better."""
FARTHEST = 4.0
"""Standard deviations of the difference."""
LEAST_SPREAD = 0.75
"""Of the plain estimate's deviation, taken for that of the difference."""
BIAS, PAIR_BIAS = 0.04, 0.25
"""Of the plain estimate, which its deviation does not include, in half-power half-widths: from the
finite model order, and from a mode that overlaps.  The end of the spectrum adds the half-width
over the distance to it: there no model of few orders describes a broad mode."""
LONGEST_REST = 8
"""Windows for which a place is left alone that the model did not describe many times."""
SAME_PLACE = 0.03
"""Distance in ln f."""
MOST_RESTS = 64
NEW = -1


@dataclass(frozen=True, slots=True)
class Adopted:
    """Modes after refinement.

    Parameters
    ----------
    modes : ModeSet
        By frequency.
    origin : tuple of int
        Where each was in the modes given; NEW for one that the likelihood found missing.
    """

    modes: ModeSet
    origin: tuple[int, ...]


def adopt_refined(samples: Samples, modes: ModeSet, harmonics: ModeSet) -> Adopted:
    """Return the modes, more precise where that is safe.

    Parameters
    ----------
    samples : Samples
        What the modes were identified from.
    modes, harmonics : ModeSet
        From the subspace identification.
    """
    return Adoption()(samples, modes, harmonics)


@dataclass(slots=True)
class _Rest:
    """A place that the model did not describe: windows to leave it, now and next time."""

    frequency_hz: float
    left: int = 1
    following: int = 2


class Adoption:
    """Adopts refined modes window after window.

    Where the model does not describe the spectrum in one window it hardly does in the next, and
    finding that out costs as much as a refinement.  Each time it does not, the modes there are
    left as they are for twice as many windows, up to ``LONGEST_REST``.

    Where it does, the refined modes of one window are where the next begins.
    """

    def __init__(self) -> None:
        self._rests: list[_Rest] = []
        self._foregoing: Foregoing | None = None
        self._channel_names: tuple[str, ...] = ()

    def __call__(self, samples: Samples, modes: ModeSet, harmonics: ModeSet) -> Adopted:
        """Return the modes of a window, see :func:`adopt_refined`."""
        known = [self._rest_of(mode) for mode in modes]
        resting = {index for index, rest in enumerate(known) if rest is not None and rest.left}
        for rest in self._rests:
            rest.left = max(0, rest.left - 1)
        if len(resting) == len(modes):
            return Adopted(modes, tuple(range(len(modes))))
        if modes.channel_names != self._channel_names:
            self._foregoing, self._channel_names = None, modes.channel_names
        try:
            refinement = refine(samples, modes, harmonics, resting, self._foregoing)
        except np.linalg.LinAlgError:
            return Adopted(modes, tuple(range(len(modes))))
        adopted, good = list[tuple[Mode, int]](), list[RefinedMode]()
        for index, (plain, refined, outcome, misfit, fit) in enumerate(
            zip(
                modes,
                refinement.modes,
                refinement.outcomes,
                refinement.misfit,
                refinement.refined,
                strict=True,
            )
        ):
            if outcome is Outcome.SUPERFLUOUS:
                continue
            beside = any(_is_beside(plain, other) for other in modes)
            bias = PAIR_BIAS if beside else BIAS
            bias += _beside_end(plain, 0.5 * samples.sample_rate_hz)
            fits = misfit <= LARGEST_MISFIT and (
                outcome is Outcome.SPLIT
                or (outcome is Outcome.REFINED and _agree(plain, refined, bias))
            )
            adopted.append((_merged(plain, refined) if fits else plain, index))
            good += [fit] if fits and fit is not None else []
            if outcome is not Outcome.NOT_TRIED:
                self._note(plain, known[index], described=misfit <= HOPELESS_MISFIT)
        adopted += [
            (mode, NEW)
            for mode, misfit in zip(refinement.added, refinement.added_misfit, strict=True)
            if misfit <= LARGEST_MISFIT
        ]
        self._foregoing = Foregoing(refinement.channels, tuple(good), refinement.slopes)
        adopted.sort(key=lambda each: each[0].frequency_hz)
        return Adopted(
            replace(modes, modes=tuple(mode for mode, _ in adopted)),
            tuple(origin for _, origin in adopted),
        )

    def _rest_of(self, mode: Mode) -> _Rest | None:
        def apart(rest: _Rest) -> float:
            return abs(math.log(rest.frequency_hz / mode.frequency_hz))

        nearest = min(self._rests, key=apart, default=None)
        return nearest if nearest is not None and apart(nearest) < SAME_PLACE else None

    def _note(self, mode: Mode, own: _Rest | None, *, described: bool) -> None:
        if described:
            self._rests = [other for other in self._rests if other is not own]
        elif own is None:
            self._rests = [*self._rests, _Rest(mode.frequency_hz)][-MOST_RESTS:]
        else:
            own.left, own.following = own.following, min(2 * own.following, LONGEST_REST)


def _is_beside(mode: Mode, other: Mode) -> bool:
    apart = abs(mode.frequency_hz - other.frequency_hz)
    width = mode.damping_ratio * mode.frequency_hz + other.damping_ratio * other.frequency_hz
    return other is not mode and apart < width


def _beside_end(mode: Mode, end_hz: float) -> float:
    """Return the half-width of a mode over its distance to the end of the spectrum."""
    left_hz = max(end_hz - mode.frequency_hz, 1e-3 * end_hz)
    return mode.damping_ratio * mode.frequency_hz / left_hz


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
    return abs(f_step) <= FARTHEST * f_spread and abs(d_step) <= FARTHEST * d_spread


def _spread(plain_std: float, refined_std: float) -> float:
    """Return √(var(plain) - var(refined)), the deviation of the difference, with a floor.

    Where both are almost as precise the bias of the plain estimate, which its deviation does not
    include, would decide.
    """
    return math.sqrt(max(plain_std**2 - refined_std**2, (LEAST_SPREAD * plain_std) ** 2))


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
    )
