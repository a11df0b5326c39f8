"""What part of a change with the level is of the mode's own motion, and what of other modes.

At a larger level all modes move more, and a spring that several of them stretch stiffens each for
all: between levels own and others' parts cannot be told apart.  Within a record they can, for
there the amplitude of each mode comes and goes by itself.

References
----------
Jeffreys (1961), Theory of Probability, 5.0: half of the belief in a value that is special.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SHARES = np.linspace(0.0, 1.0, 101)


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
    between: tuple[float, float], within: Sequence[tuple[float, float]], seen: Seen
) -> OwnShare:
    """Return the share of a mode that is not alone.

    Half of the belief beforehand is in no part of others, half in any share alike.

    Parameters
    ----------
    between : (float, float)
        Change between levels and its standard deviation.
    within : sequence of (float, float)
        The same within each record.
    seen : Seen
    """
    value, std = np.array(within).T
    weight = std**-2.0 / np.sum(std**-2.0)
    total, total_std = between
    expected = seen.gain * SHARES + seen.offset
    variance = 1.0 / np.sum(std**-2.0) + (seen.error * total) ** 2 + (expected * total_std) ** 2
    off = float(weight @ value) - expected * total
    logarithm = -0.5 * (off**2 / variance + np.log(variance))
    belief = np.full(len(SHARES), 0.5 / len(SHARES))
    belief[-1] += 0.5
    belief *= np.exp(logarithm - logarithm.max())
    belief /= belief.sum()
    mean = float(belief @ SHARES)
    return OwnShare(mean, float(np.sqrt(belief @ (SHARES - mean) ** 2)))
