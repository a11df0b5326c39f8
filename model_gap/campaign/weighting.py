"""Spectra as real rows weighted by the noise."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign.spectra import Complex, RecordSpectra

Array = NDArray[np.float64]
Rows = NDArray[np.float32]


@dataclass(frozen=True)
class Weighting:
    """How spectra become rows: real and imaginary parts over the noise.

    Parameters
    ----------
    scale : list of (n_channels, n_bins) array
        One over the root of the noise power, per record.
    measured : (n_rows,) array
        Measured spectra as rows.
    count : int
        Number of complex data.
    """

    scale: list[Array]
    measured: Rows
    count: int

    @classmethod
    def of(cls, records: Sequence[RecordSpectra]) -> 'Weighting':
        """Weight the measured spectra of records."""
        scale = [np.sqrt(1.0 / item.noise_power) for item in records]
        measured = _rows([item.measured for item in records], scale)
        return cls(scale, measured, sum(item.count for item in records))

    def rows(self, spectra: list[Complex]) -> Rows:
        """Return spectra as one weighted real vector."""
        return _rows(spectra, self.scale)

    def misfit(self, rows: Rows) -> float:
        """Return χ, the mean of |measured - predicted|² / noise power."""
        residual = (self.measured - rows).astype(float)
        return float(residual @ residual) / self.count


def _rows(spectra: list[Complex], scale: list[Array]) -> Rows:
    parts = []
    for item, weight in zip(spectra, scale, strict=True):
        scaled = (item * weight).ravel()
        parts += [scaled.real, scaled.imag]
    return np.concatenate(parts).astype(np.float32)
