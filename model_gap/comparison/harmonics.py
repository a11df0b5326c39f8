"""Lines in the measured spectra: where, how strong, and what the model says there."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.comparison.spectra_pairs import SpectraPair
from model_gap.comparison.thresholds import LIMITS

Array = NDArray[np.float64]
# Of one power over another: 120 dB below and above, more than any record of 24 bits (144 dB less
# the noise) tells of neighbouring bins.
LEAST, MOST = 1e-12, 1e12


@dataclass(frozen=True)
class LineSeen:
    """One line.

    Parameters
    ----------
    frequency_hz, resolution_hz : float [Hz]
        Where, and how finely that is known.
    channel : str
        Where it stands out most.
    over_surroundings_db, sigma_db : float [dB]
        Measured power there over that around it, and its standard deviation.
    predicted_before_db, predicted_after_db : float [dB]
        The same in the prediction.
    """

    frequency_hz: float
    resolution_hz: float
    channel: str
    over_surroundings_db: float
    sigma_db: float
    predicted_before_db: float
    predicted_after_db: float


def lines_seen(
    pairs: Sequence[SpectraPair], lines_hz: Sequence[float], channels: Sequence[str]
) -> tuple[LineSeen, ...]:
    """Return every line that was noticed, strongest first."""
    found = [_line(pairs, line, channels) for line in lines_hz]
    seen = [line for line in found if line is not None]
    return tuple(sorted(seen, key=lambda line: -line.over_surroundings_db))


def over(line: Array, around: Array) -> Array:
    """Return a power as a multiple of the one around it, by channel.

    A channel across all motion (the radial axis of a sensor on an arm of one joint) is predicted
    to see nothing at all: nothing stands out of nothing, the ratio is 1.

    Parameters
    ----------
    line, around : (n_channels,) array
        Mean powers.
    """
    ratio = np.where(line > 0.0, MOST, 1.0)
    np.divide(line, around, out=ratio, where=around > 0.0)
    return np.clip(ratio, LEAST, MOST)


def _line(pairs: Sequence[SpectraPair], line: float, channels: Sequence[str]) -> LineSeen | None:
    tables = []
    for pair in pairs:
        record = pair.item.record
        step = record.sample_rate_hz / len(record.acceleration)
        away = np.abs(pair.item.frequency_hz - line)
        near, around = (
            away <= LIMITS.near_bins * step,
            (away > 3.0 * step) & (away < LIMITS.around_hz),
        )
        if not near.any() or not around.any():
            continue
        table = np.full((3, len(channels)), np.nan)
        for row, part in zip(table, (pair.item.measured, pair.before, pair.after), strict=True):
            own = part[record.recorded]
            row[record.recorded] = over(
                np.mean(np.abs(own[:, near]) ** 2, axis=1),
                np.mean(np.abs(own[:, around]) ** 2, axis=1),
            )
        tables.append(table)
    if not tables:
        return None
    mean = np.nanmedian(np.array(tables), axis=0)
    best = int(np.nanargmax(mean[0]))
    measured, before, after = (10.0 * np.log10(mean[:, best])).tolist()
    record = pairs[0].item.record
    levels = np.array([table[0][best] for table in tables])
    scatter = 10.0 * np.log10(levels[np.isfinite(levels)])
    return LineSeen(
        frequency_hz=float(line),
        resolution_hz=record.sample_rate_hz / len(record.acceleration),
        channel=channels[best],
        over_surroundings_db=measured,
        sigma_db=float(np.std(scatter) / np.sqrt(len(scatter))),
        predicted_before_db=before,
        predicted_after_db=after,
    )
