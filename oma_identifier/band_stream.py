"""One frequency band of a stream of samples: conditioned, and summed into block covariances."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.bands import Band
from oma_identifier.condition import BandConditioner
from oma_identifier.output_covariance import (
    CovarianceAccumulator,
    OutputCovariance,
    WhenFull,
)
from oma_identifier.references import choose_references
from oma_identifier.settings import IdentificationSettings

N_BLOCKS = 64
FEWEST_BLOCK_ROWS = 20
ROWS_PER_ORDER = 1.5
"""Rows of the block Hankel matrix (and columns) per unit of the highest model order."""


@dataclass(frozen=True, slots=True)
class BandCovariance:
    """What the solver needs of one band.

    Parameters
    ----------
    band : Band
        Which band.
    covariance : OutputCovariance
        Of channels divided by ``scale``.
    scale : (n_channels,) array [m/s²]
        Root mean square in the band.
    block_rows : int
        Of the block Hankel matrix.
    references : (n_references,) int array
        Reference channels.
    """

    band: Band
    covariance: OutputCovariance
    scale: NDArray[np.float64]
    block_rows: int
    references: NDArray[np.int64]


class BandStream:
    """Conditions samples to one band and keeps their block covariances.

    Parameters
    ----------
    band : Band
        Which band.
    settings : IdentificationSettings
        Orders, block rows and references.
    span_s : float [s]
        Time the blocks shall cover.
    when_full : WhenFull
        Slide over the span, or keep everything in ever longer blocks.
    """

    def __init__(
        self, band: Band, settings: IdentificationSettings, span_s: float, when_full: WhenFull
    ) -> None:
        self.band = band
        self._settings = settings
        self._when_full = when_full
        self._block_samples = max(4, int(span_s * band.sample_rate_hz / N_BLOCKS))
        self._conditioner = BandConditioner(band)
        self._accumulator: CovarianceAccumulator | None = None
        self._block_rows = 0

    def add(self, rows: NDArray[np.float64]) -> None:
        """Add the next samples at the full rate, (n_samples, n_channels)."""
        conditioned = self._conditioner(rows)
        if len(conditioned) == 0:
            return
        if self._accumulator is None:
            self._accumulator = self._start(conditioned)
        self._accumulator.add(conditioned)

    def interrupt(self) -> None:
        """Keep the covariances, forget the filters' state: samples are missing."""
        self._conditioner = BandConditioner(self.band)
        if self._accumulator is not None:
            self._accumulator.interrupt()

    def _start(self, rows: NDArray[np.float64]) -> CovarianceAccumulator:
        references = choose_references(rows, self._settings.n_references)
        automatic = math.ceil(ROWS_PER_ORDER * self._settings.max_order / len(references))
        self._block_rows = self._settings.block_rows or max(FEWEST_BLOCK_ROWS, automatic)
        return CovarianceAccumulator(
            n_lags=2 * self._block_rows - 1,
            references=references,
            block_samples=self._block_samples,
            capacity=N_BLOCKS,
            when_full=self._when_full,
        )

    def result(self) -> BandCovariance | None:
        """Return the covariances so far; None before the first block is complete."""
        if self._accumulator is None or self._accumulator.n_blocks == 0:
            return None
        covariance = self._accumulator.result(self.band.sample_rate_hz)
        power = self._accumulator.power
        scale = np.sqrt(power)
        inverse = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0.0)
        references = self._accumulator.references
        scaled = covariance.blocks * (inverse[:, None] * inverse[references])
        return BandCovariance(
            band=self.band,
            covariance=OutputCovariance(scaled, covariance.sample_rate_hz, covariance.n_samples),
            scale=scale,
            block_rows=self._block_rows,
            references=references,
        )
