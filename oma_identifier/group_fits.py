"""Fits of all groups of modes that overlap, one band of the spectra each."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.band_data import band_lines, reduce_band, ReducedBand, StartModes
from oma_identifier.line_spectra import Spectra
from oma_identifier.whittle import (
    BandData,
    BandFit,
    fit_band,
    Patience,
    PATIENT,
    SlopePrior,
)

LEAST_LINES_PER_MODE = 12
SLOPE_STD = 1.0
"""Of the exponent of the force density, before the data: 3 dB per octave."""
SLOPE_REACH = 1.0
"""Distance in ln f over which the slope changes: an octave and a half."""


CHANCE = 1.5
"""Standard deviations of the misfit that are left to chance."""


@dataclass(frozen=True, slots=True)
class GroupFit:
    """The fit of one group of modes.

    Parameters
    ----------
    group : list of int
        Positions of the modes, the free ones of the fit in this order.
    band, fit : ReducedBand and BandFit, or None
        None where there are too few lines.
    """

    group: list[int]
    band: ReducedBand | None = None
    fit: BandFit | None = None

    @property
    def misfit(self) -> float:
        """Mean square of the whitened residual, 1 expected, less what chance may add.

        NaN without a fit.
        """
        if self.fit is None or self.band is None:
            return math.nan
        return self.fit.misfit - CHANCE * _misfit_std(self.band.data)


def _misfit_std(data: BandData) -> float:
    """Return the standard deviation of the misfit of a perfect model.

    An average of n periodograms over c channels contributes n|R|² with variance 2c² + (4c³ + 2c)/n
    (exact for n = 1, where R = xxᴴ - I).
    """
    n_channels = data.periodogram.shape[1]
    each = 2.0 * n_channels**2 + (4.0 * n_channels**3 + 2.0 * n_channels) / data.n_averaged
    return float(np.sqrt(np.sum(each)) / (len(each) * n_channels**2))


def fit_group(
    spectra: Spectra,
    start: StartModes,
    group: list[int],
    usable: NDArray[np.bool_],
    slope: SlopePrior,
    patience: Patience = PATIENT,
) -> GroupFit:
    """Fit one group of modes, the others staying where they are."""
    lines = band_lines(spectra, start, group, usable)
    if len(lines) < LEAST_LINES_PER_MODE * len(group):
        return GroupFit(group)
    band = reduce_band(spectra, start, group, lines, slope)
    return GroupFit(group, band, fit_band(band.data, band.model, patience=patience))


def updated(start: StartModes, fits: Sequence[GroupFit]) -> StartModes:
    """Return the modes after one pass; groups that did not converge stay."""
    frequency, damping = start.frequency_hz.copy(), start.damping_ratio.copy()
    shapes = start.shapes.copy()
    for each in fits:
        if each.fit is None or each.band is None or not each.fit.converged:
            continue
        count = len(each.group)
        frequency[each.group] = each.fit.model.frequency_hz[:count]
        damping[each.group] = each.fit.model.damping_ratio[:count]
        for position, mode in enumerate(each.group):
            new = each.fit.model.shapes[:, position]
            shapes[:, mode] = _whole_shape(each.band, new, start.shapes[:, mode])
    return StartModes(frequency, damping, shapes)


def _whole_shape(
    band: ReducedBand, new: NDArray[np.complex128], old: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Return the refined shape, with the old one's part that was projected out."""
    factor = np.vdot(new, band.project.T @ old)  # the new shape is of unit length
    return unit(band.projected_out @ old + band.back @ (factor * new))


def unit(shape: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return a shape of unit length."""
    length = np.linalg.norm(shape)
    return np.asarray(shape / length) if length > 0.0 else np.ones(len(shape), dtype=complex)


def pooled_slopes(fits: Sequence[GroupFit]) -> list[SlopePrior]:
    """Return for each band what the slopes of the others say about its own.

    The slope of the force density changes slowly over the logarithm of frequency; one band alone
    knows it badly, and guessing it costs information on the frequencies.  Gaussian process
    regression, each band left out in turn.
    """
    known = [each.fit for each in fits if each.fit is not None and each.fit.converged]
    if len(known) < 2:
        return [SlopePrior()] * len(fits)
    place = np.log([fit.model.reference_hz for fit in known])
    value = np.array([fit.model.slope for fit in known])
    # The fits were drawn towards the prior they had; undo that.
    first = np.array([fit.model.slope_prior.std for fit in known])
    precision = np.maximum(np.array([fit.slope_std for fit in known]) ** -2.0 - first**-2.0, 1e-3)
    value = value * (precision + first**-2.0) / precision
    kernel = SLOPE_STD**2 * np.exp(-0.5 * (np.subtract.outer(place, place) / SLOPE_REACH) ** 2)
    pooled = []
    for each in fits:
        if each.fit is None:
            pooled.append(SlopePrior())
            continue
        others = [index for index, fit in enumerate(known) if fit is not each.fit]
        cross = SLOPE_STD**2 * np.exp(
            -0.5 * ((np.log(each.fit.model.reference_hz) - place[others]) / SLOPE_REACH) ** 2
        )
        noisy = kernel[np.ix_(others, others)] + np.diag(1.0 / precision[others])
        weight = np.linalg.solve(noisy, cross)
        std = math.sqrt(max(SLOPE_STD**2 - float(weight @ cross), 1e-4))
        pooled.append(SlopePrior(float(weight @ value[others]), std))
    return pooled
