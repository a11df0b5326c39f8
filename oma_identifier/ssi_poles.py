"""Poles of one band, with what their uncertainty needs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from oma_identifier.band_stream import BandCovariance
from oma_identifier.bands import PERIODS
from oma_identifier.output_covariance import OutputCovariance
from oma_identifier.settings import IdentificationSettings
from oma_identifier.ssi_cov import (
    compress_outputs,
    factorise,
    MultiOrder,
    OrderSolution,
    output_matrix,
    poles_of_orders,
)
from oma_identifier.stabilise import BandPoles
from oma_identifier.uncertainty import influence, OrderSensitivity

MOST_OUTPUTS = 16
"""More channels are combined to this many outputs; mode shapes keep all channels."""
SAMPLES_PER_ORDER = 40
"""Samples of the record per unit of the highest model order: higher orders would fit noise."""


@dataclass(frozen=True, slots=True)
class BandIdentification:
    """Poles of one band over the model order.

    Parameters
    ----------
    source : BandCovariance
        What they were identified from.
    outputs : OutputCovariance
        Of combinations of channels where there are many.
    system : MultiOrder
        Of the block Hankel matrix of ``outputs``.
    solutions : mapping of int to OrderSolution
        By model order.
    poles : BandPoles
        All orders.
    sensitivities : dict
        By model order, filled as needed.
    series : dict
        Influence of each block of time on the pole of a row, filled as needed.
    """

    source: BandCovariance
    outputs: OutputCovariance
    system: MultiOrder
    solutions: Mapping[int, OrderSolution]
    poles: BandPoles
    sensitivities: dict[int, OrderSensitivity] = field(default_factory=dict)
    series: dict[int, NDArray[np.complex128]] = field(default_factory=dict)

    @property
    def n_orders(self) -> int:
        """How many model orders were solved."""
        return len(self.solutions)

    def influence(self, rows: Sequence[int] | NDArray[np.int64]) -> NDArray[np.complex128]:
        """Return what each block of time does to the poles in these rows.

        Returns
        -------
        (n_blocks, n_rows) complex array [rad/s]
            See :func:`oma_identifier.uncertainty.influence`.
        """
        missing = [int(row) for row in rows if int(row) not in self.series]
        if missing:
            gradients = np.array([self._gradient(row) for row in missing])
            found = influence(gradients, self.poles.eigenvalue[missing], self.outputs)
            self.series.update(zip(missing, found.T, strict=True))
        return np.column_stack([self.series[int(row)] for row in rows])

    def _gradient(self, row: int) -> NDArray[np.complex128]:
        order = int(self.poles.model_order[row])
        if order not in self.sensitivities:
            self.sensitivities[order] = OrderSensitivity(self.system, self.solutions[order])
        return self.sensitivities[order].gradient(self.poles.eigenvalue[row])


def identify_band(
    source: BandCovariance, settings: IdentificationSettings
) -> BandIdentification | None:
    """Identify the poles of one band by SSI-cov; None when the record is too short for any."""
    low_hz = max(source.band.low_hz, PERIODS / source.covariance.duration_s)
    if low_hz >= source.band.high_hz:
        return None
    source = replace(source, band=replace(source.band, low_hz=low_hz))
    highest = min(settings.max_order, source.covariance.n_samples // SAMPLES_PER_ORDER)
    orders = range(settings.min_order + settings.min_order % 2, highest + 1, 2)
    if len(orders) < 2:
        return None
    mean = source.covariance.mean
    if not np.any(mean):
        return None
    outputs = source.covariance
    if mean.shape[1] > MOST_OUTPUTS:
        outputs = _compressed(outputs, mean)
    factors = factorise(outputs.mean, source.block_rows)
    system = MultiOrder(factors, orders[-1])
    solutions = {order: system.solve(order) for order in orders if order <= system.highest}
    raw = poles_of_orders(tuple(solutions.values()), output_matrix(mean, factors))
    poles = BandPoles(
        model_order=raw.model_order,
        eigenvalue=raw.eigenvalue,
        pole=np.asarray(np.log(raw.eigenvalue) * source.covariance.sample_rate_hz, dtype=complex),
        shape=raw.shape,
    )
    return BandIdentification(source, outputs, system, solutions, poles)


def _compressed(covariance: OutputCovariance, mean: NDArray[np.float64]) -> OutputCovariance:
    combinations = compress_outputs(mean, MOST_OUTPUTS)
    return replace(covariance, blocks=combinations.T @ covariance.blocks)
