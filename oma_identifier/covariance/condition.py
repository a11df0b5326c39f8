"""Conditioning of one band: drift removal and anti-aliased decimation, block after block.

All channels pass the same causal filters.  A filter common to all channels multiplies the whole
spectrum by one number per frequency, so it moves no pole of the structure and no mode shape; its
own poles are overdamped and never taken for modes.
"""

from collections.abc import Iterator
import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from oma_identifier.covariance.bands import Band
from oma_identifier.covariance.filters import (
    butterworth_high_pass,
    kaiser_low_pass,
    RunningFilter,
)
from oma_identifier.covariance.thresholds import COVARIANCE

GROUP = 16
"""Outputs of the decimation filter that are one product of matrices."""
ROWS_AT_ONCE, FILTERED_AT_ONCE = 4096, 20_000


class Decimator:
    """Streaming anti-aliased decimation by an integer.

    Parameters
    ----------
    factor : int
        Output rate is input rate over this.
    clean : float
        Part of the new rate that passes, and that nothing is folded into.
    """

    def __init__(self, factor: int, clean: float = COVARIANCE.decimated_pass) -> None:
        self.factor = factor
        # Kaiser: length for the attenuation and transition width (Oppenheim & Schafer, 7.76)
        width = 2.0 * math.pi * (1.0 - 2.0 * clean) / factor
        n_taps = math.ceil((COVARIANCE.attenuation_db - 8.0) / (2.285 * width)) | 1
        self.taps = kaiser_low_pass(n_taps, 1.0 / factor, COVARIANCE.attenuation_db)
        # The filter is symmetric, so a row of taps is the filter itself.
        self._group = np.zeros((GROUP, (GROUP - 1) * factor + len(self.taps)))
        for row in range(GROUP):
            self._group[row, row * factor : row * factor + len(self.taps)] = self.taps
        self._past: NDArray[np.floating] | None = None

    def decimate(self, rows: NDArray[np.floating]) -> NDArray[np.float64]:
        """Filter and decimate the next rows.

        Parameters
        ----------
        rows : (n_samples, n_channels) array
            Continues what was passed before.

        Returns
        -------
        (n_decimated, n_channels) array
            As many rows as are complete now; the first comes half a filter after the start.
        """
        past = rows[:0] if self._past is None else self._past
        n_out = max(0, (len(past) + len(rows) - len(self.taps)) // self.factor + 1)
        # Only outputs that reach back see the past and rows joined; many rows are not copied.
        n_head = GROUP * math.ceil(len(past) / (GROUP * self.factor))
        if n_out <= n_head:
            data = np.concatenate([past, rows])
            self._past = data[n_out * self.factor :].copy()
            return self._filtered(data, n_out)
        used = max(0, (n_head - 1) * self.factor + len(self.taps) - len(past))
        head = np.concatenate([past, rows[:used]])
        self._past = rows[n_out * self.factor - len(past) :].copy()
        filtered = np.empty((n_out, rows.shape[1]))
        filtered[:n_head] = self._filtered(head, n_head)
        filtered[n_head:] = self._filtered(
            rows[n_head * self.factor - len(past) :], n_out - n_head
        )
        return filtered

    def _filtered(self, data: NDArray[np.floating], n_out: int) -> NDArray[np.float64]:
        """Return outputs that each see the taps from ``factor`` times their number on.

        One product of matrices makes a group of outputs of all channels.
        """
        group, reach = self._group.shape
        step = group * self.factor
        n_groups = n_out // group
        filtered = np.empty((n_out, data.shape[1]))
        at_once = max(1, ROWS_AT_ONCE // step)
        for first in range(0, n_groups, at_once):
            last = min(first + at_once, n_groups)
            part = np.asarray(data[first * step : (last - 1) * step + reach], dtype=np.float64)
            whole = sliding_window_view(part, reach, axis=0)[::step].transpose(0, 2, 1)
            found = self._group @ whole
            filtered[first * group : last * group] = found.reshape(-1, data.shape[1])
        rest = n_out - n_groups * group
        if rest:
            used = (rest - 1) * self.factor + len(self.taps)
            left = data[n_groups * step : n_groups * step + used]
            filtered[n_groups * group :] = self._group[:rest, :used] @ left
        return filtered


class HighPass:
    """Streaming high-pass filter that removes gravity, drift and rigid motion.

    Parameters
    ----------
    corner_hz, sample_rate_hz : float [Hz]
        Corner and rate.
    """

    def __init__(self, corner_hz: float, sample_rate_hz: float) -> None:
        sections = butterworth_high_pass(COVARIANCE.high_pass_order, corner_hz / sample_rate_hz)
        self._filter = RunningFilter(sections)

    def filter(self, rows: NDArray[np.floating]) -> NDArray[np.float64]:
        """Filter the next rows, (n_samples, n_channels) in and out."""
        if len(rows) == 0:
            return rows.astype(np.float64)
        # It starts as if the first row had been there for ever: gravity leaves no step.
        return self._filter.filter(rows.astype(np.float64, copy=False))


class Decimation:
    """One stream of samples at all the rates that its bands ask for, each stage made once."""

    def __init__(self) -> None:
        self.stages: dict[tuple[int, ...], tuple[Decimator, int]] = {}
        self._made: dict[tuple[int, ...], NDArray[np.floating]] = {}
        self._number = 0

    def take(self, rows: NDArray[np.floating]) -> None:
        """Take the next rows, (n_samples, n_channels)."""
        self._number += 1
        self._made = {(): rows}

    def by(self, factors: tuple[int, ...]) -> NDArray[np.floating]:
        """Return the rows taken last, decimated by all factors in turn."""
        if factors not in self._made:
            stage, last = self.stages.get(factors, (None, 0))
            if stage is None or last != self._number - 1:
                stage = Decimator(factors[-1])  # rows are missing: what it knows is too old
            self.stages[factors] = stage, self._number
            self._made[factors] = stage.decimate(self.by(factors[:-1]))
        return self._made[factors]

    def drop(self) -> None:
        """Forget the rows, which keep the window alive they were cut from, and what was made."""
        self._made = {}


class BandConditioner:
    """The filters of one band in a row.

    Parameters
    ----------
    band : Band
        Which rate and which corner.
    """

    def __init__(self, band: Band) -> None:
        self._factors = band.factors
        self._decimation = Decimation()
        self._high_pass = HighPass(band.high_pass_hz, band.sample_rate_hz)

    def condition(self, rows: NDArray[np.floating]) -> NDArray[np.float64]:
        """Condition the next rows, (n_samples, n_channels) to (n_decimated, n_channels)."""
        self._decimation.take(rows)
        conditioned = list(self.of(self._decimation))
        self._decimation.drop()
        return np.concatenate(conditioned) if conditioned else rows[:0].astype(np.float64)

    def of(self, decimation: Decimation) -> Iterator[NDArray[np.float64]]:
        """Condition the rows that a decimation shared with other bands took last, in stretches.

        The first is as long as what references are chosen by.
        """
        rows = decimation.by(self._factors)
        for first in range(0, len(rows), FILTERED_AT_ONCE):
            yield self._high_pass.filter(rows[first : first + FILTERED_AT_ONCE])
