"""Which law the stiffness and the damping of a mode follow over the level of its motion.

Each level gives a mode's stiffness and damping.  Cubic terms let them grow with the fourth over
the second moment of displacement and velocity; Coulomb friction lets them fall with the inverse of
their root mean squares.  Both are fitted, with the deviations of the values and of the amplitudes.

Damping is the width of the peak.  Where one spring moves several modes, the others change the
stiffness of this one as they come and go, and widen its peak as damping would.  A law of the width
is told only where the amplitude alone, which no change of frequency touches, has it too.  Where
it has not, or no law of stiffness explains the frequency, the amplitude may tell that damping is
constant, but no law: other modes that move this one may take its energy, too, as damping would.

References
----------
Caughey (1963), doi:10.1121/1.1918794: k₁ + k₃ E[q⁴]/E[q²], c₁ + c₃ E[q̇⁴]/E[q̇²], √(2/π) F / σ_v.
York et al. (2004), doi:10.1119/1.1632486: lines through points that scatter in both coordinates.
Birge (1932), doi:10.1103/PhysRev.40.207: deviations where χ² exceeds its mean.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from oma_identifier.levels.cubic_mode import CubicMode
from oma_identifier.levels.modal_motion import ModalMotion
from oma_identifier.levels.thresholds import LEVELS

Real = NDArray[np.float64]
STEPS = 30
"""Of the weights of a line: of 500 drawn ones the slope was off by 0.03 standard deviations at
most, by 1e-14 in 99 of 100."""


class Law(StrEnum):
    """What a quantity does over the level."""

    CONSTANT = 'constant'
    CUBIC = 'cubic'
    FRICTION = 'friction'
    CUBIC_OR_FRICTION = 'cubic or friction'
    OTHER = 'neither'
    UNKNOWN = 'not told'


@dataclass(frozen=True, slots=True)
class Line:
    """A straight line through levels.

    Parameters
    ----------
    start, slope : float
    start_std, slope_std : float
    misfit : float
        χ² of the levels.
    chance : float
        That levels of this law have such a χ² or a larger one.
    """

    start: float
    slope: float
    start_std: float
    slope_std: float
    misfit: float
    chance: float


@dataclass(frozen=True, slots=True)
class QuantityLaw:
    """Law of stiffness or damping.

    Parameters
    ----------
    law : Law
        The one the levels tell.
    cubic : Line
        Over the fourth over the second moment.
    friction : Line
        Over the inverse of its root.
    farthest : float
        Of the levels, each predicted by the others and the cubic law: the largest difference in
        standard deviations.
    """

    law: Law
    cubic: Line
    friction: Line
    farthest: float


@dataclass(frozen=True, slots=True)
class LevelLaw:
    """A mode over the level of its motion.

    Parameters
    ----------
    mode : CubicMode
        By the cubic law of both, also where another is told: see ``stiffness.law``.
    frequency_std_hz, damping_ratio_std : float
    cubic_stiffness_std : float [1/(m² s²)]
    cubic_damping_std : float [s/m²]
        NaN where the law of damping is unknown.
    stiffness, damping : QuantityLaw
    by_amplitude : bool
        Whether damping is told to be constant by the amplitude alone: the width has more in it.
    """

    mode: CubicMode
    frequency_std_hz: float
    damping_ratio_std: float
    cubic_stiffness_std: float
    cubic_damping_std: float
    stiffness: QuantityLaw
    damping: QuantityLaw
    by_amplitude: bool = False


def level_law(motions: Sequence[ModalMotion]) -> LevelLaw | None:
    """Return the law of a mode over levels; None where no stiffness is left without motion.

    What cubic stiffness does to the width of a peak, as the amplitude comes and goes, is no
    damping: it is taken out first.

    Parameters
    ----------
    motions : sequence of ModalMotion
        At each level, three or more, at one channel.
    """
    relative = np.array([each.relative_std for each in motions])
    stiffness = _law_of(
        np.array([each.stiffness for each in motions]),
        np.array([each.stiffness_std for each in motions]),
        np.array([each.square_m2 for each in motions]),
        np.array([each.displacement_m for each in motions]),
        relative,
    )
    k = stiffness.cubic
    if k.start <= 0.0:
        return None
    bent = stiffness.law in (Law.CUBIC, Law.CUBIC_OR_FRICTION)
    half_width_hz, half_width_std = np.array(
        [
            each.half_width_hz(0.375 * k.slope / math.sqrt(each.stiffness) if bent else 0.0)
            for each in motions
        ]
    ).T
    by_width = _damping_of(motions, half_width_hz, half_width_std)
    alone = np.array([each.amplitude_half_width_hz() for each in motions]).T
    by_amplitude = _damping_of(motions, alone[0], alone[1])
    start = math.sqrt(k.start)
    moved_hz = abs(k.slope) * max(each.square_m2 for each in motions) / (4.0 * math.pi * start)
    moved = moved_hz / half_width_hz.min() if bent else 0.0
    agree = moved < LEVELS.most_bent and _agree(by_width, by_amplitude)
    damping = by_width if agree else by_amplitude
    explained = agree and stiffness.law is not Law.OTHER
    told = moved < LEVELS.half_widths and (explained or damping.law is Law.CONSTANT)
    c = damping.cubic
    ratio = c.start / (2.0 * start)
    return LevelLaw(
        CubicMode(start / (2.0 * math.pi), ratio, k.slope, c.slope),
        k.start_std / (2.0 * start) / (2.0 * math.pi),
        math.hypot(c.start_std / (2.0 * start), ratio * k.start_std / (2.0 * k.start)),
        k.slope_std,
        c.slope_std if told else math.nan,
        stiffness,
        damping if told else replace(damping, law=Law.UNKNOWN),
        by_amplitude=told and not agree,
    )


def _damping_of(motions: Sequence[ModalMotion], half_width_hz: Real, std: Real) -> QuantityLaw:
    return _law_of(
        4.0 * math.pi * half_width_hz,
        4.0 * math.pi * std,
        np.array([each.square_m2_s2 for each in motions]),
        np.array([each.velocity_m_s for each in motions]),
        np.array([each.relative_std for each in motions]),
    )


def _agree(by_width: QuantityLaw, by_amplitude: QuantityLaw) -> bool:
    """Tell whether the width changes with the level as the amplitude alone has it."""
    wide, alone = by_width.cubic, by_amplitude.cubic
    apart = abs(wide.slope - alone.slope) / math.hypot(wide.slope_std, alone.slope_std)
    if apart > LEVELS.confirmed_std:
        return False
    if by_width.law is Law.CONSTANT:
        return True
    if by_width.law is Law.OTHER:
        return by_amplitude.law is not Law.CONSTANT
    dry = by_width.law is Law.FRICTION
    wide, alone = (by_width.friction, by_amplitude.friction) if dry else (wide, alone)
    return math.copysign(alone.slope, alone.slope * wide.slope) > (
        LEVELS.confirmed_std * alone.slope_std
    )


def _law_of(
    value: Real, value_std: Real, square: Real, amplitude: Real, relative: Real
) -> QuantityLaw:
    inverse = 1.0 / amplitude
    cubic = _line(square, 2.0 * relative * square, value, value_std)
    friction = _line(inverse, relative * inverse, value, value_std)
    return QuantityLaw(
        _told(value, value_std, cubic, friction),
        cubic,
        friction,
        _farthest(square, 2.0 * relative * square, value, value_std),
    )


def _told(value: Real, value_std: Real, cubic: Line, friction: Line) -> Law:
    """Return the law that the levels tell."""
    weight = value_std**-2.0
    mean = np.sum(weight * value) / np.sum(weight)
    constant = float(np.sum(weight * (value - mean) ** 2))
    if constant - min(cubic.misfit, friction.misfit) < LEVELS.told_std**2:
        chance = float(chdtrc(len(value) - 1, constant))
        return Law.CONSTANT if chance > LEVELS.least_chance else Law.OTHER
    if max(cubic.chance, friction.chance) < LEVELS.least_chance:
        return Law.OTHER
    if friction.misfit - cubic.misfit > LEVELS.told_apart:
        return Law.CUBIC
    if cubic.misfit - friction.misfit > LEVELS.told_apart:
        return Law.FRICTION
    return Law.CUBIC_OR_FRICTION


def _line(x: Real, x_std: Real, y: Real, y_std: Real) -> Line:
    """Return the line through points with deviations of both coordinates."""
    slope = 0.0
    for _ in range(STEPS):
        weight = 1.0 / (y_std**2 + (slope * x_std) ** 2)
        total = weight.sum()
        x_mean, y_mean = weight @ x / total, weight @ y / total
        spread = weight @ (x - x_mean) ** 2
        slope = float(weight @ ((x - x_mean) * (y - y_mean)) / spread)
    start = float(y_mean - slope * x_mean)
    misfit = float(weight @ (y - start - slope * x) ** 2)
    scale = math.sqrt(max(1.0, misfit / (len(x) - 2)))
    return Line(
        start,
        slope,
        scale * math.sqrt(1.0 / total + x_mean**2 / spread),
        scale / math.sqrt(spread),
        misfit,
        float(chdtrc(len(x) - 2, misfit)),
    )


def _farthest(x: Real, x_std: Real, y: Real, y_std: Real) -> float:
    """Return the largest difference of a level from what the others predict, in deviations."""
    if len(x) <= LEVELS.fewest_levels:
        return math.nan
    differences = []
    for left_out in range(len(x)):
        kept = np.arange(len(x)) != left_out
        line = _line(x[kept], x_std[kept], y[kept], y_std[kept])
        weight = 1.0 / (y_std[kept] ** 2 + (line.slope * x_std[kept]) ** 2)
        centre = weight @ x[kept] / weight.sum()
        own = y_std[left_out] ** 2 + (line.slope * x_std[left_out]) ** 2
        std = math.sqrt(own + 1.0 / weight.sum() + (line.slope_std * (x[left_out] - centre)) ** 2)
        differences.append(abs(y[left_out] - line.start - line.slope * x[left_out]) / std)
    return float(max(differences))
