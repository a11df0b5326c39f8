"""Poles of one band, with what their uncertainty needs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
import logging
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.covariance import Band, COVARIANCE
from oma_identifier.selection.stabilise import BandPoles
from oma_identifier.selection.thresholds import SELECTION
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import (
    BandCovariance,
    deviation_from,
    factorise,
    factorise_canonical,
    HankelFactors,
    influence,
    MultiOrder,
    OrderSolution,
    output_matrix,
    PoleDeviation,
    poles_of_orders,
    PoleSensitivity,
    SUBSPACE,
)

EVERY_ORDER_TO = 28
ORDERS_SHARE = 6
SAMPLES_PER_ORDER = 40
"""Samples of the record per unit of the highest model order: higher orders would fit noise."""

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class BandIdentification:
    """Poles of one band over the model order.

    Parameters
    ----------
    source : BandCovariance
        What they were identified from.
    system : MultiOrder
        Of the block Hankel matrix.
    solutions : mapping of int to OrderSolution
        By model order.
    poles : BandPoles
        All orders.
    """

    source: BandCovariance
    system: MultiOrder
    solutions: Mapping[int, OrderSolution]
    poles: BandPoles

    @property
    def n_orders(self) -> int:
        """How many model orders were solved."""
        return len(self.solutions)

    @property
    def band(self) -> Band:
        """Which band."""
        return self.source.band

    @property
    def scale(self) -> NDArray[np.float64]:
        """Root mean square of the channels in the band, (n_channels,) array [m/s²]."""
        return self.source.scale

    @property
    def duration_s(self) -> float:
        """Length of the record [s]."""
        return self.source.covariance.duration_s

    @property
    def least_members(self) -> int:
        """Model orders over which a mode repeats: one in so many, gradients tell the rest."""
        return max(3, math.ceil(self.n_orders / ORDERS_SHARE))

    @property
    def is_blind(self) -> bool:
        """No force is known."""
        return True

    @property
    def trials(self) -> Sequence[float]:
        """The member of lowest order too."""
        return SELECTION.trials

    def deviation(self, series: NDArray[np.complex128], pole: complex) -> PoleDeviation:
        """Return the standard deviations of a pole; neighbouring blocks are correlated."""
        return deviation_from(series, pole, self.duration_s)

    @cached_property
    def _sensitivity(self) -> PoleSensitivity:
        return PoleSensitivity(self.system)

    def influence(self, rows: NDArray[np.int64]) -> NDArray[np.complex128]:
        """Return what each block of time does to the poles in these rows.

        Returns
        -------
        (n_blocks, n_rows) complex array [rad/s]
            See :func:`oma_identifier.subspace.uncertainty.influence`.
        """
        values = self.poles.eigenvalue[rows]
        solutions = [self.solutions[order] for order in self.poles.model_order[rows].tolist()]
        gradients = self._sensitivity.gradients(solutions, values)
        return influence(gradients, values, self.source.covariance)


def model_orders(lowest: int, highest: int) -> list[int]:
    """Return the even model orders to solve: all low ones, every other of the high ones.

    A pole that is stable from one high order to the next but one is stable in between, and the
    time of a solution grows with the cube of its order.
    """
    return [
        order
        for order in range(lowest + lowest % 2, highest + 1, 2)
        if order <= EVERY_ORDER_TO or (highest - order) % 4 == 0
    ]


def identify_band(
    source: BandCovariance, settings: IdentificationSettings
) -> BandIdentification | None:
    """Identify the poles of one band by SSI-cov; None when the record is too short for any."""
    low_hz = max(source.band.low_hz, COVARIANCE.periods / source.covariance.duration_s)
    if low_hz >= source.band.high_hz:
        log.debug(
            'band to %.4g Hz: %.4g s are too short for it',
            source.band.high_hz,
            source.covariance.duration_s,
        )
        return None
    source = replace(source, band=replace(source.band, low_hz=low_hz))
    highest = min(source.max_order, source.covariance.n_samples // SAMPLES_PER_ORDER)
    orders = model_orders(settings.min_order, highest)
    if len(orders) < 2:
        log.debug(
            'band to %.4g Hz: %d samples are too few for two model orders',
            source.band.high_hz,
            source.covariance.n_samples,
        )
        return None
    if not np.any(source.mean):
        log.debug('band to %.4g Hz: nothing moves in it', source.band.high_hz)
        return None
    return _solved(source, factorise(source.covariance.mean, source.block_rows), orders)


def _solved(
    source: BandCovariance, factors: HankelFactors, orders: Sequence[int]
) -> BandIdentification:
    system = MultiOrder(factors, orders[-1])
    solutions = {order: system.solve(order) for order in orders if order <= system.highest}
    raw = poles_of_orders(tuple(solutions.values()), output_matrix(source.mean, factors))
    poles = BandPoles(
        model_order=raw.model_order,
        eigenvalue=raw.eigenvalue,
        pole=np.asarray(np.log(raw.eigenvalue) * source.covariance.sample_rate_hz, dtype=complex),
        shape=raw.shape,
    )
    return BandIdentification(source, system, solutions, poles)


def identify_canonical(plain: BandIdentification) -> BandIdentification | None:
    """Identify the poles of a band once more, by canonical variates of its references.

    None where the record is too short for so many of them, or there is no time for it.
    """
    if plain.source.own is None:
        return None
    source = replace(plain.source, covariance=plain.source.own)
    n_rows = source.block_rows * len(source.at_once)
    if source.covariance.n_samples < SUBSPACE.canonical_samples * n_rows:
        return None
    factors = factorise_canonical(source.covariance.mean, source.at_once, source.block_rows)
    return _solved(source, factors, tuple(plain.solutions))
