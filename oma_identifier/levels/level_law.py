"""Which law the stiffness and the damping of a mode follow over the level of its motion.

Each level gives a mode's stiffness and damping.  Cubic terms let them grow with the fourth over
the second moment of displacement and velocity.  A spring that begins beyond a gap (play), or that
slips there (friction), stiffens or softens by the share of the motion that is beyond; dry friction
lets damping fall with the inverse of the motion.  What else there may be has a second term.  All
are fitted, with the deviations of the values and of the amplitudes, and compared by how likely the
levels are under each.  A law is named where the others are less than one in twenty as likely, and
never where its χ² is improbable; what a mode has where it hardly moves is the mean over all laws,
by how likely they are, and what is between them counts in its deviation.

Damping is the width of the peak.  Where one spring moves several modes, the others change the
stiffness of this one as they come and go, and widen its peak as damping would.  A law of the width
is told only where the amplitude alone, which no change of frequency touches, has it too.  Where
it has not, or no law of stiffness explains the frequency, the amplitude may tell that damping is
constant, but no law: other modes that move this one may take its energy, too, as damping would.

References
----------
Caughey (1963), doi:10.1121/1.1918794: k₁ + k₃ E[q⁴]/E[q²], c₁ + c₃ E[q̇⁴]/E[q̇²], √(2/π) F / σ_v.
Hoeting et al. (1999), doi:10.1214/ss/1009212519: means over models, and their deviations.
Birge (1932), doi:10.1103/PhysRev.40.207: deviations where χ² exceeds its mean.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc

from oma_identifier.levels.anchor import Anchor, stiffness_at_levels, width_anchor
from oma_identifier.levels.cubic_mode import CubicMode
from oma_identifier.levels.law_fit import (
    averaged,
    fit_law,
    Law,
    LawFit,
    LevelData,
    mixed,
    Shape,
    weights,
)
from oma_identifier.levels.modal_motion import ModalMotion
from oma_identifier.levels.own_share import ALL_OWN, DAMPING, own_share, OwnShare, STIFFNESS
from oma_identifier.levels.thresholds import LEVELS

Real = NDArray[np.float64]
GAPS = 32
"""Between a quarter of the smallest and four times the largest motion; chosen."""


@dataclass(frozen=True, slots=True)
class QuantityLaw:
    """Law of stiffness or damping.

    Parameters
    ----------
    laws : tuple of Law
        Those that the levels leave: one of them holds.
    start, start_std : float
        Where the mode hardly moves, of all laws by how likely they are.
    cubic : LawFit
    fits : tuple of LawFit
        All, the likeliest first.
    another_level : float
        Amplitude at which the two likeliest of several laws would be told apart, [m] of stiffness
        and [m/s] of damping; NaN where none would, or one is left.
    """

    laws: tuple[Law, ...]
    start: float
    start_std: float
    cubic: LawFit
    fits: tuple[LawFit, ...] = ()
    another_level: float = math.nan

    @property
    def words(self) -> str:
        """The laws that are left, for people."""
        return ' or '.join(self.laws)

    @property
    def may_be_cubic(self) -> bool:
        """Whether the levels leave a cubic law, which a constant is one of."""
        return self.is_constant or Law.CUBIC in self.laws

    @property
    def is_constant(self) -> bool:
        """Whether no change is told."""
        return self.laws == (Law.CONSTANT,)


@dataclass(frozen=True, slots=True)
class LevelLaw:
    """A mode over the level of its motion.

    Parameters
    ----------
    mode : CubicMode
        Where it hardly moves, with the terms of the cubic law of both, also where another is told:
        see ``stiffness.laws``.
    frequency_std_hz, damping_ratio_std : float
        The latter NaN where the law of damping is unknown.
    cubic_stiffness_std : float [1/(m² s²)]
    cubic_damping_std : float [s/m²]
        NaN where the law of damping is unknown.  Both NaN where the levels exclude a cubic law.
    stiffness, damping : QuantityLaw
    by_amplitude : bool
        Whether damping is told to be constant by the amplitude alone: the width has more in it.
    stiffness_share, damping_share : OwnShare
        Of the cubic terms in ``stiffness`` and ``damping``, which all modes may have a part in,
        what ``mode`` has.
    """

    mode: CubicMode
    frequency_std_hz: float
    damping_ratio_std: float
    cubic_stiffness_std: float
    cubic_damping_std: float
    stiffness: QuantityLaw
    damping: QuantityLaw
    by_amplitude: bool = False
    stiffness_share: OwnShare = ALL_OWN
    damping_share: OwnShare = ALL_OWN


def level_law(motions: Sequence[ModalMotion]) -> LevelLaw | None:
    """Return the law of a mode over levels; None where no stiffness is left without motion.

    What cubic stiffness does to the width of a peak, as the amplitude comes and goes, is no
    damping: it is taken out first.

    Parameters
    ----------
    motions : sequence of ModalMotion
        At each level, three or more, at one channel.
    """
    stiffness = _stiffness_of(motions)
    k = stiffness.cubic
    if stiffness.start <= 0.0:
        return None
    bent = Law.CUBIC in stiffness.laws
    stiffness_share = _share_of_stiffness(motions, k)
    k3, k3_std = stiffness_share.of(k.slope, k.slope_std)
    half_width_hz, half_width_std = np.array(
        [
            each.half_width_hz(0.375 * k3 / math.sqrt(each.stiffness) if bent else 0.0)
            for each in motions
        ]
    ).T
    brings = width_anchor(motions)
    by_width = _damping_of(motions, brings, half_width_hz, half_width_std)
    alone = np.array([each.amplitude_half_width_hz() for each in motions]).T
    by_amplitude = _damping_of(motions, brings, alone[0], alone[1])
    start = math.sqrt(stiffness.start)
    moved_hz = abs(k.slope) * max(each.square_m2 for each in motions) / (4.0 * math.pi * start)
    moved = moved_hz / half_width_hz.min() if bent else 0.0
    agree = moved < LEVELS.most_bent and _agree(by_width, by_amplitude)
    damping = by_width if agree else by_amplitude
    explained = agree and Law.OTHER not in stiffness.laws
    told = moved < LEVELS.half_widths and (explained or damping.is_constant)
    damping_share = _share_of_damping(motions, damping.cubic)
    c3, c3_std = damping_share.of(damping.cubic.slope, damping.cubic.slope_std)
    ratio = damping.start / (2.0 * start)
    return LevelLaw(
        CubicMode(start / (2.0 * math.pi), ratio, k3, c3),
        stiffness.start_std / (2.0 * start) / (2.0 * math.pi),
        math.hypot(
            damping.start_std / (2.0 * start), ratio * stiffness.start_std / stiffness.start / 2.0
        )
        if told
        else math.nan,
        k3_std if stiffness.may_be_cubic else math.nan,
        c3_std if told and damping.may_be_cubic else math.nan,
        stiffness,
        damping if told else replace(damping, laws=(Law.UNKNOWN,)),
        told and not agree,
        stiffness_share,
        damping_share,
    )


def _share_of_stiffness(motions: Sequence[ModalMotion], cubic: LawFit) -> OwnShare:
    odds = float(np.median([each.moves_over_others[0] for each in motions]))
    within = [each.stiffness_within() for each in motions]
    return own_share((cubic.slope, cubic.slope_std), within, STIFFNESS, odds)


def _share_of_damping(motions: Sequence[ModalMotion], cubic: LawFit) -> OwnShare:
    odds = float(np.median([each.moves_over_others[1] for each in motions]))
    within = []
    for each in motions:
        damping = cubic.start + cubic.slope * each.square_m2_s2
        slope, std = each.damping_within()
        within.append((damping * slope, abs(damping) * std))
    return own_share((cubic.slope, cubic.slope_std), within, DAMPING, odds)


def _stiffness_of(motions: Sequence[ModalMotion]) -> QuantityLaw:
    known = stiffness_at_levels(motions)
    data = LevelData(
        known.value,
        known.covariance,
        np.array([each.displacement_m for each in motions]),
        np.array([each.relative_std for each in motions]),
    )
    gaps = np.geomspace(0.25 * data.amplitude.min(), 4.0 * data.amplitude.max(), GAPS)
    beyond = np.array([each.share_beyond(gaps) for each in motions])
    seen = np.flatnonzero(beyond.max(axis=0) > LEVELS.least_beyond).tolist()
    springs = [
        [_beyond(law, sign, data, float(gaps[n]), beyond[:, n]) for n in seen]
        for law, sign in ((Law.PLAY, 1.0), (Law.FRICTION, -1.0))
    ]
    square = np.array([each.square_m2 for each in motions])
    return _law_of(data, square, springs, LEVELS.stiffness_change)


def _beyond(law: Law, sign: float, data: LevelData, gap: float, at_levels: Real) -> Shape:
    """Return a spring that begins, or slips, where the motion is beyond a gap."""
    over = gap / data.amplitude
    steep = math.sqrt(2.0 / math.pi) * over * np.exp(-0.5 * over**2)

    def columns(amplitude: Real) -> Real:
        return np.asarray(erfc(gap / math.sqrt(2.0) / amplitude))[:, None]

    return Shape(law, columns, at_levels[:, None], steep[:, None], sign)


def _damping_of(
    motions: Sequence[ModalMotion], brings: Anchor, half_width_hz: Real, std: Real
) -> QuantityLaw:
    data = LevelData(
        *brings.of(4.0 * math.pi * half_width_hz, 4.0 * math.pi * std),
        np.array([each.velocity_m_s for each in motions]),
        np.array([each.relative_std for each in motions]),
    )

    def inverse(amplitude: Real) -> Real:
        return np.asarray(data.amplitude.min() / amplitude)[:, None]

    dry = Shape(Law.FRICTION, inverse, inverse(data.amplitude), -inverse(data.amplitude), 1.0)
    square = np.array([each.square_m2_s2 for each in motions])
    return _law_of(data, square, [[dry]], LEVELS.damping_change)


def _agree(by_width: QuantityLaw, by_amplitude: QuantityLaw) -> bool:
    """Tell whether the width changes with the level as the amplitude alone has it."""
    wide, alone = by_width.cubic, by_amplitude.cubic
    apart = abs(wide.slope - alone.slope) / math.hypot(wide.slope_std, alone.slope_std)
    if apart > LEVELS.confirmed_std:
        return False
    if by_width.is_constant:
        return True
    if Law.OTHER in by_width.laws:
        return not by_amplitude.is_constant
    if Law.CUBIC not in by_width.laws:
        wide, alone = (
            next(fit for fit in each.fits if fit.law is Law.FRICTION)
            for each in (by_width, by_amplitude)
        )
    return math.copysign(alone.slope, alone.slope * wide.slope) > (
        LEVELS.confirmed_std * alone.slope_std
    )


def _law_of(
    data: LevelData, square: Real, rivals: Sequence[Sequence[Shape]], change: float
) -> QuantityLaw:
    """Return what laws the levels leave.

    Parameters
    ----------
    data : LevelData
    square : (n,) array
        Fourth over second moment of the motion, at the levels.
    rivals : sequence of sequence of Shape
        Laws beside the constant, the cubic and another one, each at all its gaps.
    change : float
        Standard deviation of what a term adds at the largest level, over the values, beforehand.
    """
    fits = _fits(data, square, rivals, change)
    free = [each.misfit / each.freedom for each in fits if each.freedom > 0]
    scale = max(1.0, min(free))
    if scale > 1.0:
        data = replace(data, covariance=scale * data.covariance)
        wider = _fits(data, square, rivals, change)
        fits = [replace(new, misfit=old.misfit) for old, new in zip(fits, wider, strict=True)]
    cubic = next(each for each in fits if each.law is Law.CUBIC)
    # What is told to be constant may yet change a little.
    starts = [cubic if each.law is Law.CONSTANT else each for each in fits]
    start, start_std = averaged(
        weights([each.evidence for each in fits]),
        [(each.start, each.start_std) for each in starts],
    )
    fits.sort(key=lambda each: -each.evidence)
    left = _left(fits)
    rivals_left = [each for each in fits if each.law in left][:2]
    another = _another_level(data, rivals_left) if len(rivals_left) > 1 else math.nan
    return QuantityLaw(left, start, start_std, cubic, tuple(fits), another)


def _fits(
    data: LevelData, square: Real, rivals: Sequence[Sequence[Shape]], change: float
) -> list[LawFit]:
    per_square = float(np.mean(square / data.amplitude**2))

    def squares(amplitude: Real) -> Real:
        return np.asarray(per_square * amplitude**2)[:, None]

    def bent(amplitude: Real) -> Real:
        return np.hstack([squares(amplitude), squares(amplitude) ** 2])

    nothing = np.empty((len(square), 0))
    s = square[:, None]
    shapes = (
        Shape(Law.CONSTANT, lambda amplitude: np.empty((len(amplitude), 0)), nothing, nothing),
        Shape(Law.CUBIC, squares, s, 2.0 * s),
        Shape(Law.OTHER, bent, np.hstack([s, s**2]), np.hstack([2.0 * s, 4.0 * s**2])),
    )
    fits = [fit_law(data, each, change, 1 + each.at_levels.shape[1]) for each in shapes]
    for law in rivals:
        free = 2 + (len(law) > 1)
        fits.append(mixed([fit_law(data, each, change, free) for each in law]))
    return fits


def _another_level(data: LevelData, fits: Sequence[LawFit]) -> float:
    """Return the amplitude at which two laws differ most, half to twice as far as was measured."""
    at = np.sort(data.amplitude)
    tried = np.concatenate([[0.5 * at[0]], np.sqrt(at[1:] * at[:-1]), [2.0 * at[-1]]])
    one, other = (each.course(tried) for each in fits)
    relative_std = float(np.median(np.sqrt(np.diag(data.covariance)) / data.value))
    apart = np.abs(one - other) / (relative_std * np.maximum(one, other))
    best = int(np.argmax(apart))
    enough = apart[best] > math.sqrt(2.0 * math.log(LEVELS.odds))
    return float(tried[best]) if enough else math.nan


def _left(fits: Sequence[LawFit]) -> tuple[Law, ...]:
    """Return the laws that the levels leave, the likeliest first.

    Of a constant and a law that only may change, it is the constant; of a cubic law and one that
    only may have a further term the cubic one.
    """
    probable = [each for each in fits if each.chance > LEVELS.least_chance]
    least = fits[0].evidence - math.log(LEVELS.odds)
    left = [each.law for each in probable if each.evidence > least]
    if Law.CONSTANT in left:
        return (Law.CONSTANT,)
    if Law.CUBIC in left and Law.OTHER in left:
        left.remove(Law.OTHER)
    return tuple(left) or (Law.OTHER,)
