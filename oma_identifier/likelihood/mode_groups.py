"""Modes in groups whose bands overlap, and the frequencies that each group is fitted to."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.indices import ModeIndex
from oma_identifier.likelihood.line_spectra import Spectra
from oma_identifier.likelihood.thresholds import LIKELIHOOD

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class StartModes:
    """Poles and shapes a refinement starts from.

    Parameters
    ----------
    frequency_hz, damping_ratio : (n_modes,) array [Hz], [-]
        Natural frequencies and damping ratios.
    shapes : (n_channels, n_modes) complex array
        Of unit length.
    """

    frequency_hz: Real
    damping_ratio: Real
    shapes: Complex

    def indices(self) -> Iterator[ModeIndex]:
        """Yield the position of each mode."""
        return map(ModeIndex, range(len(self.frequency_hz)))

    @property
    def half_width_hz(self) -> Real:
        """Half-power half-widths ζf [Hz]."""
        return self.frequency_hz * self.damping_ratio


def overlaps(frequency_hz: Real, half_width_hz: Real) -> NDArray[np.bool_]:
    """Tell of each two modes whether their half-power bandwidths touch, (n_modes, n_modes)."""
    apart = np.abs(frequency_hz[:, None] - frequency_hz)
    return np.asarray(apart <= half_width_hz[:, None] + half_width_hz)


def group_modes(start: StartModes, least_hz: float) -> list[list[ModeIndex]]:
    """Group modes whose bands overlap; narrow the bands of groups that are too large.

    Bands are those of half-widths of ``least_hz`` at least: nothing narrower is resolved.
    """
    modes = [ModeIndex(int(mode)) for mode in np.argsort(start.frequency_hz)]
    return _grouped(start, modes, np.maximum(start.half_width_hz, least_hz), _reach(start))


def _reach(start: StartModes) -> float:
    one_channel = len(start.shapes) == 1
    return LIKELIHOOD.reach_of_one_channel if one_channel else LIKELIHOOD.reach


def _grouped(
    start: StartModes, modes: list[ModeIndex], width_hz: Real, reach: float
) -> list[list[ModeIndex]]:
    low = start.frequency_hz - reach * width_hz
    high = start.frequency_hz + reach * width_hz
    groups: list[list[ModeIndex]] = []
    for mode in modes:
        if groups and low[mode] < max(high[other] for other in groups[-1]):
            groups[-1].append(mode)
        else:
            groups.append([mode])
    result: list[list[ModeIndex]] = []
    for group in groups:
        if len(group) > LIKELIHOOD.most_modes and reach > LIKELIHOOD.least_reach:
            result += _grouped(start, group, width_hz, 0.8 * reach)
        else:
            result.append(group)
    return result


def band_lines(
    spectra: Spectra, start: StartModes, group: list[ModeIndex], usable: NDArray[np.bool_]
) -> NDArray[np.intp]:
    """Return the usable frequencies around a group of modes.

    Those beside the peaks that lie nearer to another mode, in half-widths, are left out: it does
    not move in the fit.
    """
    width = np.maximum(start.half_width_hz, spectra.spacing_hz)
    reach = _reach(start) * width[group]
    low = np.min(start.frequency_hz[group] - reach)
    low = max(low, LIKELIHOOD.lowest_share * start.frequency_hz[group[0]])
    high = np.max(start.frequency_hz[group] + reach)
    frequency = spectra.frequency_hz
    lines = np.flatnonzero(usable & (frequency >= low) & (frequency <= high))
    away = np.abs(frequency[lines, None] - start.frequency_hz) / width
    own = away[:, group].min(axis=1)
    return np.asarray(lines[(own <= away.min(axis=1)) | (own < LIKELIHOOD.least_reach)])
