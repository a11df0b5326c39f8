"""Lines in the spectra that stand at the same frequency in every record."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Band, GapRecord, hann, record_spectra
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LineLimits:
    """What is a line.

    Parameters
    ----------
    least_prominence : float
        Power over the running median, in the response over that in the known motion.
    least_rest_prominence : float
        The same of what a model leaves over, the mean of all channels.
    most_lines : int
        At most so many.
    apart_hz : float [Hz]
        Closer lines are one.
    least_record_share : float
        Of the records must show it.
    median_neighbours : int
        Bins of the running median to either side.
    """

    least_prominence: float = 12.0
    least_rest_prominence: float = 4.0
    most_lines: int = 3
    apart_hz: float = 0.6
    least_record_share: float = 0.6
    median_neighbours: int = 24


LIMITS = LineLimits()


def common_lines(
    records: Sequence[GapRecord], band: Band, most: int = LIMITS.most_lines
) -> tuple[float, ...]:
    """Return frequencies of lines seen in most records, strongest first [Hz].

    The spectrum of every channel is divided by its own running median and by that of the known
    motion, so that neither resonances nor lines of the excitation count.

    Parameters
    ----------
    records : sequence of GapRecord
        Of one campaign.
    band : Band
        Where to look.
    most : int
        At most so many.
    """
    scores = []
    for record in records:
        own = record.acceleration[:, record.recorded]
        frequency, response = _prominence(own, record.sample_rate_hz, band)
        _, motion = _prominence(record.motor_acceleration, record.sample_rate_hz, band)
        scores.append((frequency, response / np.maximum(motion, 1.0)))
    return _common(records, scores, band, LIMITS.least_prominence, most)


def lines_left(
    predictor: Predictor, hypothesis: Hypothesis, band: Band, known: Sequence[float]
) -> tuple[float, ...]:
    """Return lines that stand out of what a hypothesis leaves over, known ones first [Hz].

    Where the model is right but for a hum, the hum stands out of the noise, not of the response.

    Parameters
    ----------
    predictor : Predictor
        Of the fitting records.
    hypothesis : Hypothesis
        Without tones.
    band : Band
        Where to look.
    known : sequence of float [Hz]
        Lines seen already.
    """
    records = [item.record for item in predictor.records]
    every = [record_spectra(record, band, len(record.acceleration)) for record in records]
    fine = replace(predictor, records=every)
    scores = []
    for item, squares in zip(every, fine.squares(hypothesis.cell()), strict=True):
        power = np.mean(squares, axis=0)
        scores.append((item.frequency_hz, power / np.maximum(_running_median(power), 1e-30)))
    found = _common(records, scores, band, LIMITS.least_rest_prominence, LIMITS.most_lines)
    new = [line for line in found if all(abs(line - other) > LIMITS.apart_hz for other in known)]
    return (*known, *new)


def _common(
    records: Sequence[GapRecord],
    scores: Sequence[tuple[Array, Array]],
    band: Band,
    least: float,
    most: int,
) -> tuple[float, ...]:
    """Return where the scores of most records are high, strongest first."""
    grid = np.arange(band.low_hz, band.high_hz, 0.05)
    rows = []
    for frequency, score in scores:
        width = max(1, round(0.1 / (frequency[1] - frequency[0])))
        padded = np.pad(score, width, mode='edge')
        widened = np.max([padded[i : i + len(score)] for i in range(2 * width + 1)], axis=0)
        rows.append(np.interp(grid, frequency, widened, right=0.0))
    level = np.quantile(np.array(rows), 1.0 - LIMITS.least_record_share, axis=0)
    found: list[float] = []
    while len(found) < most and level.max() > least:
        place = int(np.argmax(level))
        found.append(_exact(records, float(grid[place])))
        level[np.abs(grid - grid[place]) < LIMITS.apart_hz] = 0.0
    return tuple(found)


def _prominence(values: np.ndarray, rate_hz: float, band: Band) -> tuple[np.ndarray, np.ndarray]:
    """Return power over its running median around a band, and at which frequencies [Hz]."""
    spectrum = np.fft.rfft(values - values.mean(axis=0), axis=0)
    every = np.fft.rfftfreq(len(values), 1.0 / rate_hz)
    wide = 2 * LIMITS.median_neighbours  # medians see neighbours, and lines are widened
    first, last = np.searchsorted(every, (band.low_hz, band.high_hz))
    full = np.arange(max(first - wide, 1), min(last + wide, len(spectrum) - 1))
    power = np.abs(hann(spectrum[full[:, None] + np.array([-1, 0, 1])].transpose(2, 0, 1))) ** 2
    frequency = every[full]
    floor = np.array([_running_median(row) for row in power])
    relative = power / np.maximum(floor, 1e-30)
    return frequency, np.asarray(np.median(relative, axis=0))


def _running_median(row: np.ndarray) -> np.ndarray:
    padded = np.pad(row, LIMITS.median_neighbours, mode='edge')
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * LIMITS.median_neighbours + 1)
    return np.asarray(np.median(windows[:, ::2], axis=1))


def _exact(records: Sequence[GapRecord], near_hz: float) -> float:
    """Refine a line by maximising the power of all records on a fine grid."""
    trials = near_hz + np.linspace(-0.12, 0.12, 97)
    total = np.zeros(len(trials))
    for record in records:
        own = record.acceleration[:, record.recorded]
        values = own - own.mean(axis=0)
        window = np.hanning(len(values))[:, None]
        time = np.arange(len(values)) / record.sample_rate_hz
        kernel = np.exp(-2j * np.pi * trials[:, None] * time)
        power = np.abs(kernel @ (values * window)) ** 2
        total += np.sum(power / values.var(axis=0), axis=1)
    return float(trials[int(np.argmax(total))])
