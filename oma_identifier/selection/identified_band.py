"""What the selection asks of the poles of a band, whatever method they come from."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from oma_identifier.covariance import Band
from oma_identifier.selection.stabilise import BandPoles
from oma_identifier.subspace import PoleDeviation


class IdentifiedBand(Protocol):
    """Poles of one band over the model order, and what makes them scatter."""

    @property
    def band(self) -> Band:
        """Which band."""

    @property
    def poles(self) -> BandPoles:
        """All orders."""

    @property
    def n_orders(self) -> int:
        """How many model orders were solved."""

    @property
    def scale(self) -> NDArray[np.float64]:
        """Root mean square of the channels in the band, (n_channels,) array [m/s²]."""

    @property
    def duration_s(self) -> float:
        """Length of the record [s]."""

    @property
    def least_members(self) -> int:
        """Model orders over which a mode repeats at least."""

    @property
    def is_blind(self) -> bool:
        """Whether no force is known, so that the limit of scatter under random forces holds."""

    @property
    def trials(self) -> Sequence[float]:
        """Which members of a cluster are compared, as shares of it by model order."""

    def influence(self, rows: NDArray[np.int64]) -> NDArray[np.complex128]:
        """Return what each block of time does to the poles in these rows.

        Returns
        -------
        (n_blocks, n_rows) complex array [rad/s]
            An estimate's error is the mean of its column over the blocks.
        """

    def deviation(self, series: NDArray[np.complex128], pole: complex) -> PoleDeviation:
        """Return the standard deviations of a pole from its influence series."""
