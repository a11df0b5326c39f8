"""Where a cubic spring carries a load."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class CubicRoot:
    """y of y (1 + α y²) = value; softening, on the branch that rises, up to its end.

    Parameters
    ----------
    alpha : (n,) array
        Of every value.

    References
    ----------
    Viète's trigonometric solution of the cubic, and its hyperbolic form for one real root.
    """

    def __init__(self, alpha: Array) -> None:
        self.soft = alpha < 0.0
        self.any_soft = bool(self.soft.any())
        size = np.sqrt(3.0 * np.abs(alpha) + 1e-30)
        self.inward, self.outward = 1.5 * size, 2.0 / size

    def __call__(self, value: Array) -> Array:
        """Return y, (n,)."""
        scaled = self.inward * value
        found = np.sinh(np.arcsinh(scaled) / 3.0)
        if self.any_soft:
            soft = np.sin(np.arcsin(np.minimum(np.maximum(scaled, -1.0), 1.0)) / 3.0)
            found = np.where(self.soft, soft, found)
        return np.asarray(found * self.outward)
