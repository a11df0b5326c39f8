"""Periodograms of a band averaged finely at its peaks, and coarsely beside them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.band_model import (
    BandData,
    BandModel,
    expected_spectra,
    forced_gain,
)
from oma_identifier.likelihood.known_mean import columns_at, Mean
from oma_identifier.likelihood.line_spectra import VALUES_AT_ONCE
from oma_identifier.likelihood.thresholds import LIKELIHOOD

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def averages_from(
    frequency_hz: Real,
    values: Complex,
    centres_hz: Real,
    half_widths_hz: Real,
    durations_s: Sequence[float] = (0.0,),
) -> BandData:
    """Average the periodograms of a band, finely at its peaks and coarsely beside them.

    Parameters
    ----------
    frequency_hz : (n_lines,) array [Hz]
        Usable frequencies of the band.
    values : (n_lines, n_channels) complex array
        Discrete Fourier transforms there.
    centres_hz, half_widths_hz : (n_modes,) array [Hz]
        Peaks and their half-power half-widths.
    durations_s : sequence of float [s]
        Of the stretches that the lines are of; only looked at where there are several.
    """
    apart = np.diff(frequency_hz)
    spacing = widest = float(apart.min())
    if len(durations_s) > 1:
        spacing, widest = 1.0 / sum(durations_s), 1.0 / min(durations_s)
    gaps = np.append(np.flatnonzero(apart > 1.5 * widest) + 1, len(frequency_hz))
    first = _first_of_averages(frequency_hz, gaps, spacing, centres_hz, half_widths_hz)
    return _averaged(frequency_hz, values, first)


def averaged_again(data: BandData, values: Complex) -> BandData:
    """Return the same averages of other values of their lines."""
    summed = _summed_products(values, _firsts(data.n_averaged))
    return replace(data, periodogram=summed / data.n_averaged[:, None, None])


def _firsts(count: Real) -> NDArray[np.intp]:
    return np.asarray(np.append(0, np.cumsum(count[:-1])), dtype=np.intp)


def parts_wanted(data: BandData, model: BandModel, mean: Mean | None = None) -> NDArray[np.intp]:
    """Return into how many parts each average must be divided, (n_averages,).

    Within an average the response turns from one shape to the next.  Under forces of full rank
    that is nothing beside its scatter; under one force it is all that is seen beside the noise,
    and so it is under known ones, whose response has a mean.
    """
    low, high = (
        replace(data, frequency_hz=data.frequency_hz + side * data.spread_hz) for side in (-1, 1)
    )
    change = model.shapes * 0.5 * (forced_gain(high, model) - forced_gain(low, model))[:, None, :]
    covariance = expected_spectra(model, model.shapes * forced_gain(data, model)[:, None, :])
    within = change @ model.force @ change.conj().transpose(0, 2, 1)
    if mean is not None and data.known is not None:
        ends = (columns_at(side.frequency_hz, data.known, model) for side in (high, low))
        driven = 0.5 * np.subtract(*ends) @ mean.coefficients
        within += driven @ data.known.power @ driven.conj().transpose(0, 2, 1)
    turned = np.einsum('kii->k', np.linalg.solve(covariance, within)).real
    wanted = np.sqrt(np.maximum(turned, 0.0) / LIKELIHOOD.turned)
    return np.asarray(np.clip(np.ceil(wanted), 1, data.n_averaged), dtype=np.intp)


def divided(
    data: BandData, parts: NDArray[np.intp], frequency_hz: Real, values: Complex
) -> BandData:
    """Return averages over parts of those before, as equal as may be."""
    first, count = _firsts(data.n_averaged), data.n_averaged.astype(np.intp)
    begin = [
        at + (np.arange(n) * length) // n
        for at, length, n in zip(first, count, parts, strict=True)
    ]
    return _averaged(frequency_hz, values, np.concatenate(begin))


def _averaged(frequency_hz: Real, values: Complex, first: NDArray[np.intp]) -> BandData:
    count = np.diff(np.append(first, len(frequency_hz))).astype(float)
    mean_hz = np.add.reduceat(frequency_hz, first) / count
    away = frequency_hz - np.repeat(mean_hz, count.astype(np.intp))
    spread_hz = np.sqrt(np.add.reduceat(away**2, first) / count)
    periodogram = _summed_products(values, first) / count[:, None, None]
    return BandData(mean_hz, periodogram, count, spread_hz)


def _summed_products(values: Complex, first: NDArray[np.intp]) -> Complex:
    """Return the products of the channels with one another, summed from each first line on.

    Some averages at a time: a broad band has tens of thousands of lines.
    """
    n_lines, n_channels = values.shape
    at_once = max(1, VALUES_AT_ONCE // n_channels**2)
    summed = np.empty((len(first), n_channels, n_channels), dtype=complex)
    ends = np.append(first[1:], n_lines)
    begin = 0
    while begin < len(first):
        end = max(begin + 1, int(np.searchsorted(ends, first[begin] + at_once, side='right')))
        part = values[first[begin] : ends[end - 1]]
        products = part[:, :, None] * part[:, None, :].conj()
        summed[begin:end] = np.add.reduceat(products, first[begin:end] - first[begin], axis=0)
        begin = end
    return summed


def _first_of_averages(
    frequency_hz: Real,
    gaps: NDArray[np.intp],
    spacing: float,
    centres_hz: Real,
    half_widths_hz: Real,
) -> NDArray[np.intp]:
    """Return where each average starts: narrow at the peaks, wider away from them.

    None reaches over lines that are left out.
    """
    distance = np.abs(frequency_hz[:, None] - centres_hz)
    at_peak = half_widths_hz / LIKELIHOOD.averages_per_half_width
    beside = (distance - half_widths_hz) / LIKELIHOOD.averages_per_distance
    width = np.maximum(at_peak, beside).min(axis=1)
    count = np.maximum(1, (width / spacing).astype(int))
    first, at = [], 0
    while at < len(frequency_hz):
        first.append(at)
        at = min(at + int(count[at]), int(gaps[np.searchsorted(gaps, at, side='right')]))
    return np.array(first)
