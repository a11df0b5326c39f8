"""Fits of all groups of modes that overlap, one band of the spectra each."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.averages import averaged_again, divided, parts_wanted
from oma_identifier.likelihood.band_model import BandData, BandFit, BandModel
from oma_identifier.likelihood.few_forces import (
    count_forces,
    FAR,
    under_few_forces,
    with_residuals,
)
from oma_identifier.likelihood.fit_band import ConvergenceLimits, FIRST_PASS, fit_band
from oma_identifier.likelihood.indices import BandIndex, ModeIndex
from oma_identifier.likelihood.line_spectra import Spectra
from oma_identifier.likelihood.mode_groups import band_lines, StartModes
from oma_identifier.likelihood.record_ends import without_ends
from oma_identifier.likelihood.reduced_band import reduce_band, ReducedBand
from oma_identifier.likelihood.thresholds import LIKELIHOOD


@dataclass(frozen=True, slots=True)
class GroupFit:
    """The fit of one group of modes.

    Parameters
    ----------
    group : list of ModeIndex
        The free modes of the fit, in this order.
    band, fit : ReducedBand and BandFit, or None
        None where there are too few lines.
    coarse : bool
        The averages are still too wide for what the response turns within them.
    without : GroupFit or None
        The fit without known inputs, where this is one with them.
    """

    group: list[ModeIndex]
    band: ReducedBand | None = None
    fit: BandFit | None = None
    coarse: bool = False
    without: 'GroupFit | None' = None

    def members(self) -> Iterator[tuple[BandIndex, ModeIndex]]:
        """Yield each free mode with its position in the fit."""
        for position, mode in enumerate(self.group):
            yield BandIndex(position), mode

    def position(self, mode: ModeIndex) -> BandIndex:
        """Return the position of a mode in the fit."""
        return BandIndex(self.group.index(mode))

    @property
    def misfit(self) -> float:
        """Mean square of the whitened residual, 1 expected, less what chance may add.

        NaN without a fit.
        """
        if self.fit is None or self.band is None:
            return math.nan
        return self.fit.misfit - LIKELIHOOD.misfit_chance * _misfit_std(self.band.data)


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
    group: list[ModeIndex],
    usable: NDArray[np.bool_],
    convergence: ConvergenceLimits = FIRST_PASS,
    begin: Callable[[ReducedBand], BandModel | None] = lambda _: None,
) -> GroupFit:
    """Fit one group of modes, the others staying where they are.

    ``begin`` says where in a band to begin, if it knows.  Averages in which the response turns by
    more than its scatter are divided, and fitted again.
    """
    lines = band_lines(spectra, start, group, usable)
    if not _enough(lines, group):
        return GroupFit(group)
    band, values = reduce_band(spectra, start, group, lines)
    return _fitted(spectra, band, values, group, convergence, begin)


def fit_with_residuals(
    spectra: Spectra,
    start: StartModes,
    group: list[ModeIndex],
    usable: NDArray[np.bool_],
) -> GroupFit:
    """Fit one group under few forces that move every channel beside the modes as well.

    What modes that nobody found do in a band changes little over it: each force moves the channels
    along with itself.  Fewer assumptions than those of :func:`fit_group`, and larger deviations.

    References
    ----------
    Ewins (2000), Modal Testing, 2nd ed., section 4.4 (residuals).
    """
    lines = band_lines(spectra, start, group, usable)
    if not _enough(lines, group):
        return GroupFit(group)
    n_forces = count_forces(spectra.at(lines).T.astype(np.complex128))
    n_moved = len(start.frequency_hz) + len(FAR) * len(spectra.values)
    if not 0 < 2 * n_forces * n_moved <= LIKELIHOOD.most_root_parameters:
        return GroupFit(group)
    band, values = reduce_band(spectra, start, group, lines, few_forces=True)
    wider = with_residuals(band.model)
    model = under_few_forces(band.data, wider, n_forces)
    return _fitted(spectra, replace(band, model=model), values, group, FIRST_PASS, lambda _: None)


def _fitted(
    spectra: Spectra,
    band: ReducedBand,
    values: NDArray[np.complex128],
    group: list[ModeIndex],
    convergence: ConvergenceLimits,
    begin: Callable[[ReducedBand], BandModel | None],
) -> GroupFit:
    lines = band.lines
    near = begin(band)
    for left in reversed(range(LIKELIHOOD.most_divisions + 1)):
        cleaned = without_ends(spectra, lines, values, band.data, near or band.model)
        band = replace(band, data=averaged_again(band.data, cleaned))
        fit = fit_band(band.data, band.model, convergence=convergence, near=near)
        parts = parts_wanted(band.data, fit.model)
        if not left or np.all(parts <= LIKELIHOOD.coarse_parts):
            break
        near = fit.model if fit.converged else near
        band = replace(band, data=divided(band.data, parts, spectra.frequency_hz[lines], cleaned))
    return GroupFit(group, band, fit, coarse=bool(np.any(parts > LIKELIHOOD.coarse_parts)))


def _enough(lines: NDArray[np.intp], group: list[ModeIndex]) -> bool:
    return len(lines) >= LIKELIHOOD.least_lines_per_mode * len(group)


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
        for position, mode in each.members():
            new = each.fit.model.shapes[:, position]
            shapes[:, mode] = whole_shape(each.band, new, start.shapes[:, each.group])
    return StartModes(frequency, damping, shapes)


def whole_shape(
    band: ReducedBand, new: NDArray[np.complex128], old: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Return a shape of unit length, refined but for what was projected out.

    That is taken from the old shapes, in the mixture that comes nearest to the new one.

    Parameters
    ----------
    band : ReducedBand
        In which it was refined.
    new : (n_reduced,) complex array
        Refined, of unit length.
    old : (n_channels, n_old) complex array
        Of the modes of the band.
    """
    mixture = np.linalg.lstsq(band.project.T @ old, new, rcond=LIKELIHOOD.separable)[0]
    return unit(band.projected_out(old @ mixture) + band.back @ new)


def unit(shape: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return a shape of unit length."""
    length = np.linalg.norm(shape)
    return np.asarray(shape / length) if length > 0.0 else np.ones(len(shape), dtype=complex)
