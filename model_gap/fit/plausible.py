"""Prior of an effect's numbers: what is plausible is likely, and nothing in its range is absurd.

A normal prior charges x²/2 at x deviations: 450 at thirty, against which no evidence stands, and
it pulls at a number that is told to a few percent by many of its deviations.  Cauchy's, -log p =
log(1 + x²/2), is as curved where an effect does nothing, charges 6 at thirty and pulls by 2/x: by
twice the relative deviation, in deviations.

References
----------
Gelman, Jakulin, Pittau and Su (2008), doi:10.1214/08-AOAS191: Cauchy priors for effects whose
size is known by order of magnitude.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# log √π: of Cauchy's density less is near the middle than of the normal one, which has 0 here.
SPREAD = 0.5 * float(np.log(np.pi))


def cost(scaled: Array) -> float:
    """Return minus the log prior density of numbers in prior scales, (n,)."""
    return float(np.sum(np.log1p(0.5 * scaled**2) + SPREAD))


def weight(scaled: Array) -> Array:
    """Return what pulls at each number per number, (n,): its slope is that times the number.

    It stands for the curvature as well: positive everywhere, and exact in the middle.
    """
    return np.asarray(1.0 / (1.0 + 0.5 * scaled**2))
