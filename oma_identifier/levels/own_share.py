"""What part of a change with the level is of the mode's own motion, and what of other modes.

At a larger level all modes move more, and a spring that several of them stretch stiffens each for
all: between levels own and others' parts cannot be told apart.  Within a record they can, for
there the amplitude of each mode comes and goes by itself.  That scatters, and a mode that moves
much drives others with its combination tones, so that they come and go with it.  So it counts how
much modes move, too: what one of them adds goes with the square of its motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from scipy.special import expit

REACH, STEPS = 6.0, 401
"""Of the odds that are tried, in standard deviations of their logarithm, and how many."""
ODDS_SLOPE, ODDS_STD = 0.85, 2.3
"""Of the logarithm of own over others' part, with that of the mode's motion over all others', and
about it: of 12,000 modes of 3,000 random chains with springs that are not linear at one place or
two, under forces and through a base, 96 and 95 % are within two deviations (seed 981590)."""


@dataclass(frozen=True, slots=True)
class OwnShare:
    """Share of the mode's own motion, 0 to 1.

    Parameters
    ----------
    value, std : float
    """

    value: float
    std: float

    @property
    def others_told(self) -> bool:
        """Whether other modes have a part in the change beyond doubt."""
        return self.value + 2.0 * self.std < 1.0

    def of(self, total: float, total_std: float) -> tuple[float, float]:
        """Return what of a change is of its own, and its standard deviation."""
        spread = (self.value * total_std) ** 2 + (total**2 + total_std**2) * self.std**2
        return self.value * total, float(np.sqrt(spread))


@dataclass(frozen=True, slots=True)
class Seen:
    """What a change within a record is, of one that is all the mode's own.

    Parameters
    ----------
    gain, offset : float
        Within over between levels is gain times share plus offset.
    error : float
        Standard deviation of that.
    """

    gain: float
    offset: float
    error: float


ALL_OWN = OwnShare(1.0, 0.0)
STIFFNESS = Seen(1.0, -0.15, 0.2)
DAMPING = Seen(1.3, 0.0, 0.3)
"""Of simulated single oscillators and chains of two to five masses, cubic in both, three levels of
60 to 300 s, change told: stiffness within less share -0.14 ± 0.08 (8 oscillators) and -0.20 ± 0.11
(12 modes of chains), for a band cuts off a part and cubic damping ties phase to amplitude; damping
within over 1.3 shares 0.1 ± 0.3 (11).  Errors are half as large again for stiffness."""


def own_share(
    between: tuple[float, float],
    within: Sequence[tuple[float, float]],
    seen: Seen,
    moves_over_others: float,
) -> OwnShare:
    """Return the share of a mode.

    Parameters
    ----------
    between : (float, float)
        Change between levels and its standard deviation.
    within : sequence of (float, float)
        The same within each record.
    seen : Seen
    moves_over_others : float
        Mean square of the mode's motion over that of all others; infinite: it is alone.
    """
    if math.isinf(moves_over_others):
        return ALL_OWN
    value, std = np.array(within).T
    weight = std**-2.0 / np.sum(std**-2.0)
    total, total_std = between
    away = np.linspace(-REACH, REACH, STEPS)
    odds = ODDS_SLOPE * math.log(max(moves_over_others, 1e-300)) + ODDS_STD * away
    shares = expit(odds)
    expected = seen.gain * shares + seen.offset
    variance = 1.0 / np.sum(std**-2.0) + (seen.error * total) ** 2 + (expected * total_std) ** 2
    off = float(weight @ value) - expected * total
    logarithm = -0.5 * (off**2 / variance + np.log(variance) + away**2)
    belief = np.exp(logarithm - logarithm.max())
    belief /= belief.sum()
    mean = float(belief @ shares)
    return OwnShare(mean, float(np.sqrt(belief @ (shares - mean) ** 2)))
