"""Lines in the spectra that stand at the same frequency in every record."""

from collections.abc import Sequence

import numpy as np

from model_gap.campaign import GapRecord
from model_gap.spectra import Band, hann

LEAST_PROMINENCE = 12.0
LEAST_SHARE = 0.6
NEIGHBOURS = 24


def common_lines(records: Sequence[GapRecord], band: Band, most: int = 3) -> tuple[float, ...]:
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
    grid = np.arange(band.low_hz, band.high_hz, 0.05)
    scores = []
    for record in records:
        frequency, response = _prominence(record.acceleration, record.sample_rate_hz)
        _, motion = _prominence(record.motor_acceleration, record.sample_rate_hz)
        score = response / np.maximum(motion, 1.0)
        width = max(1, round(0.1 / (frequency[1] - frequency[0])))
        padded = np.pad(score, width, mode='edge')
        score = np.max([padded[i : i + len(score)] for i in range(2 * width + 1)], axis=0)
        scores.append(np.interp(grid, frequency, score))
    table = np.array(scores)
    level = np.quantile(table, 1.0 - LEAST_SHARE, axis=0)
    found: list[float] = []
    while len(found) < most and level.max() > LEAST_PROMINENCE:
        place = int(np.argmax(level))
        found.append(_exact(records, float(grid[place])))
        level[np.abs(grid - grid[place]) < 0.6] = 0.0
    return tuple(found)


def _prominence(values: np.ndarray, rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    spectrum = np.fft.rfft(values - values.mean(axis=0), axis=0)
    full = np.arange(1, len(spectrum) - 1)
    power = np.abs(hann(spectrum[full[:, None] + np.array([-1, 0, 1])].transpose(2, 0, 1))) ** 2
    frequency = np.fft.rfftfreq(len(values), 1.0 / rate_hz)[full]
    floor = np.array([_running_median(row) for row in power])
    relative = power / np.maximum(floor, 1e-30)
    return frequency, np.asarray(np.median(relative, axis=0))


def _running_median(row: np.ndarray) -> np.ndarray:
    padded = np.pad(row, NEIGHBOURS, mode='edge')
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1)
    return np.asarray(np.median(windows[:, ::2], axis=1))


def _exact(records: Sequence[GapRecord], near_hz: float) -> float:
    """Refine a line by maximising the power of all records on a fine grid."""
    trials = near_hz + np.linspace(-0.12, 0.12, 97)
    total = np.zeros(len(trials))
    for record in records:
        values = record.acceleration - record.acceleration.mean(axis=0)
        window = np.hanning(len(values))[:, None]
        time = np.arange(len(values)) / record.sample_rate_hz
        kernel = np.exp(-2j * np.pi * trials[:, None] * time)
        power = np.abs(kernel @ (values * window)) ** 2
        total += np.sum(power / values.var(axis=0), axis=1)
    return float(trials[int(np.argmax(total))])
