"""One frequency band of a stream of samples: conditioned, and summed into block covariances."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.covariance import (
    Band,
    BandConditioner,
    choose_references,
    CovarianceAccumulator,
    Decimation,
    OutputCovariance,
    WhenFull,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace.late_lags import lack_modes, leaves_more_than_chance
from oma_identifier.subspace.ssi_cov import compress_outputs
from oma_identifier.subspace.thresholds import SUBSPACE

N_COVARIANCE_BLOCKS = 64


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class BandCovariance:
    """What the solver needs of one band; equal is only what is the same object.

    Parameters
    ----------
    band : Band
        Which band.
    mean : (n_lags, n_channels, n_references) array
        Covariance of the channels divided by ``scale`` with the references, over all blocks.
    covariance : OutputCovariance
        The same in blocks, of combinations of the channels where there are many of them.
    scale : (n_channels,) array [m/s²]
        Root mean square in the band.
    block_rows : int
        Of the block Hankel matrix.
    max_order : int
        Highest model order that so many rows are for.
    own : OutputCovariance or None
        As ``covariance``, of the references with one another; None where there is no time to solve
        a band twice.
    at_once : (n_references, n_references) array
        Of the references with one another at lag 0, where their noise is.
    """

    band: Band
    mean: NDArray[np.float64]
    covariance: OutputCovariance
    scale: NDArray[np.float64]
    block_rows: int
    max_order: int
    own: OutputCovariance | None
    at_once: NDArray[np.float64]


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
    turn : int
        Bands with different turns are refreshed one after the other when hops are short.
    fold : int
        Times the orders of the settings.
    """

    def __init__(
        self,
        band: Band,
        settings: IdentificationSettings,
        span_s: float,
        when_full: WhenFull,
        turn: int = 0,
        fold: int = 1,
    ) -> None:
        self.band = band
        self.turn = turn
        self._order = fold * settings.max_order
        self._settings = settings
        self._when_full = when_full
        self._block_samples = max(4, int(span_s * band.sample_rate_hz / N_COVARIANCE_BLOCKS))
        self._conditioner = BandConditioner(band)
        self._accumulator: CovarianceAccumulator | None = None
        self._block_rows = 0
        self._last: BandCovariance | None = None
        self._last_of = 0
        self._ask_at = N_COVARIANCE_BLOCKS // 2

    def add(self, rows: Decimation) -> None:
        """Add the samples that were taken last."""
        for conditioned in self._conditioner.of(rows):
            if self._accumulator is None:
                self._accumulator = self._start(conditioned)
            self._accumulator.add(conditioned.astype(np.float32))

    def interrupt(self) -> None:
        """Keep the covariances, forget the filters' state: samples are missing."""
        self._conditioner = BandConditioner(self.band)
        if self._accumulator is not None:
            self._accumulator.interrupt()

    def _start(self, rows: NDArray[np.float64]) -> CovarianceAccumulator:
        wanted = self._settings.n_references or SUBSPACE.most_references
        references = choose_references(rows, min(wanted, SUBSPACE.most_references))
        automatic = math.ceil(SUBSPACE.rows_per_order * self._order / len(references))
        self._block_rows = self._settings.block_rows or max(SUBSPACE.fewest_block_rows, automatic)
        # What slides must be fast: of it later lags are not asked.
        may_double = self._settings.block_rows is None and self._when_full is WhenFull.JOIN
        return CovarianceAccumulator(
            n_lags=2 * (1 + may_double) * self._block_rows - 1,
            references=references,
            block_samples=self._block_samples,
            capacity=N_COVARIANCE_BLOCKS,
            when_full=self._when_full,
        )

    def is_crowded(self) -> bool:
        """Tell whether there are more modes than the orders hold; asked now and then, it is dear.

        A band with twice the orders, or with rows that a user chose, is not asked.
        """
        blocks, settings = self._accumulator, self._settings
        if settings.block_rows is not None or self._order > settings.max_order:
            return False
        if blocks is None or blocks.n_added < self._ask_at:
            return False
        self._ask_at = blocks.n_added + SUBSPACE.spans_between * N_COVARIANCE_BLOCKS
        of_band = self.result()
        return of_band is not None and leaves_more_than_chance(
            of_band.covariance, of_band.block_rows, self._order
        )

    def result(self) -> BandCovariance | None:
        """Return the covariances so far; None before the first block is complete.

        Of a sliding window the same object as last time as long as less than
        ``SUBSPACE.refreshed`` of the blocks are new: so few change a result by a third of its
        standard deviation.
        """
        blocks = self._accumulator
        if blocks is None or blocks.n_blocks == 0:
            return None
        slides = self._when_full is WhenFull.RETIRE
        least = SUBSPACE.refreshed * N_COVARIANCE_BLOCKS if slides else 1
        if self._last is None or blocks.n_added - self._last_of >= least:
            first = self._last is None
            self._last, self._last_of = self._result(blocks), blocks.n_added
            if first:
                self._last_of -= self.turn
        return self._last

    def _result(self, blocks: CovarianceAccumulator) -> BandCovariance:
        scale = np.sqrt(blocks.power)
        inverse = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0.0)
        weight = inverse[blocks.references]
        mean = blocks.mean * (inverse[:, None] * weight)
        outputs, rows = np.diag(inverse), self._block_rows
        if len(scale) > SUBSPACE.most_outputs:
            first = mean[: 2 * rows - 1]
            outputs = inverse[:, None] * compress_outputs(first, SUBSPACE.most_outputs)
        rate_hz, own = self.band.sample_rate_hz, None
        covariance = blocks.result(rate_hz, outputs, weight)
        if self._when_full is WhenFull.JOIN or self._settings.refines:
            own = blocks.result(rate_hz, np.diag(inverse)[:, blocks.references], weight)
        order = self._order
        if len(mean) >= 2 * rows and lack_modes(covariance, rows, order):
            rows, order = 2 * rows, 2 * order
        n_lags = 2 * rows - 1
        return BandCovariance(
            band=self.band,
            mean=mean[:n_lags],
            covariance=covariance.up_to(n_lags),
            scale=scale,
            block_rows=rows,
            max_order=order,
            own=own and own.up_to(n_lags),
            at_once=blocks.at_once * np.outer(weight, weight),
        )
