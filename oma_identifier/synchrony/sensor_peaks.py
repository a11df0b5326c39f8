"""Spectra of all channels around the peaks of a window: where one mode outweighs all else."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import ifft, next_fast_len, rfft
from scipy.ndimage import uniform_filter1d

from modal_core.numbers.prominence import crossings, prominent_peaks
from modal_core.samples import Samples
from modal_core.work.free_memory import LARGE_BYTES
from oma_identifier.synchrony.thresholds import SYNCHRONY

TAPERS = 3
"""Sine tapers; each line is then blurred by two others to either side."""
SINE_KURTOSIS = 2.0 / 3.0
"""Mean of sin², squared, over that of sin⁴: what the first taper does to a fourth moment."""
WIDTH = 0.01
"""Share of a frequency that its power is averaged over to find peaks: as broad as a mode of 0.5 %
damping, which is next to nothing to a broader one."""
FEWEST_LINES = 9
MOST_PEAKS = 16
CHANNELS_AT_ONCE, FEW_AT_ONCE = 16, 4
"""Transformed together; of large windows fewer, as the steps of one take seven times its size."""
MOST_LINES_OF_PEAK = 400
"""A broader peak tells no more than this many lines of it."""

Columns = Mapping[str, NDArray[np.int64]]
"""Channels by sensor: what shares a clock."""
Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Single = NDArray[np.complex64]


@dataclass(frozen=True, slots=True)
class Peak:
    """Lines about one peak, those of half its height or more.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Middle of the power.
    line_hz : (n_lines,) array [Hz]
        From ``frequency_hz``.
    single : (TAPERS, n_lines, n_channels) complex array
        Spectra of channels of unit variance, as precise as they are made.
    """

    frequency_hz: float
    line_hz: Real
    single: Single

    @property
    def spectra(self) -> Complex:
        """The same to calculate with: a copy, which is best looked at one peak at a time."""
        return self.single.astype(np.complex128)

    @property
    def n_free(self) -> float:
        """Independent values among the spectra, about."""
        return float(len(self.line_hz) + TAPERS - 1)

    @property
    def is_line(self) -> bool:
        """Whether its motion keeps its amplitude all the time, as that of a machine does."""
        if len(self.line_hz) < SYNCHRONY.beat_lines:
            return False
        # Back in time: the squared amplitude is that of the motion times the first taper, sin².
        power = np.abs(ifft(self.single[0], 2 * len(self.line_hz), axis=0)) ** 2
        square = np.sum(np.mean(power, axis=0) ** 2)
        kurtosis = SINE_KURTOSIS * np.sum(np.mean(power**2, axis=0)) / square
        return bool(kurtosis < SYNCHRONY.line_kurtosis)


def sensor_peaks(samples: Samples) -> list[Peak]:
    """Return the peaks of the mean of all channels' spectra, the most prominent ones.

    What makes the peaks does not depend on when the channels were sampled.

    References
    ----------
    Riedel and Sidorenko (1995), doi:10.1109/78.365298 (sine tapers, and their transforms as
    differences of lines).
    """
    half = transform_length(samples)
    step_hz = samples.sample_rate_hz / half
    own = np.arange(TAPERS, int(SYNCHRONY.top * half / 2))
    power = np.zeros(len(own))
    fits = 8 * half * len(samples.channels) < LARGE_BYTES
    held = []
    for fine in _transforms(samples, half, len(samples.channels) if fits else FEW_AT_ONCE):
        power += _power(fine, len(own))
        held += [fine] if fits else []
    ranges = _ranges(own, power)
    if not ranges:
        return []
    wanted = np.concatenate([own[first:last] for first, last in ranges])
    # Else transformed once more, rather than spectra of all channels in memory.
    again = held if fits else _transforms(samples, half, FEW_AT_ONCE)
    every = np.empty((TAPERS, len(wanted), len(samples.channels)), dtype=np.complex64)
    first = 0
    for fine in again:
        every[:, :, first : first + fine.shape[1]] = _tapered(fine, wanted)
        first += fine.shape[1]
    ends = np.cumsum([last - first for first, last in ranges])
    return [
        _peak(single, power[first:last], step_hz * own[first:last].astype(np.float64))
        for single, (first, last) in zip(np.split(every, ends[:-1], axis=1), ranges, strict=True)
    ]


def transform_length(samples: Samples) -> int:
    """Return the rows that a transform of a window reaches over, zeros at its end included."""
    return int(next_fast_len(len(samples.acceleration)))


def _transforms(samples: Samples, half: int, at_once: int) -> Iterator[Single]:
    """Yield the transforms of a few channels at a time, (half + 1, n_channels)."""
    for first in range(0, len(samples.channels), at_once):
        single = _of_unit_size(samples.widened(columns=slice(first, first + at_once)))
        for column in range(0, single.shape[1], CHANNELS_AT_ONCE):
            # Twice the lines: taper k is a difference of lines k above and below.
            yield rfft(single[:, column : column + CHANNELS_AT_ONCE], 2 * half, axis=0)


def _of_unit_size(rows: Real) -> NDArray[np.float32]:
    rows = rows - rows.mean(axis=0)
    size = np.sqrt(np.einsum('tc,tc->c', rows, rows) / len(rows))
    single = np.empty(rows.shape, dtype=np.float32)
    np.divide(rows, np.where(size > 0.0, size, np.inf), out=single, casting='same_kind')
    return single


def _power(fine: Single, n_lines: int) -> Real:
    """Return the power of all channels and tapers in the lines from ``TAPERS`` on."""
    power = np.zeros(n_lines)
    for taper in range(1, TAPERS + 1):
        below, above = (fine[2 * TAPERS + k :: 2][:n_lines] for k in (-taper, taper))
        parts = (below - above).view(np.float32)
        power += np.einsum('lc,lc->l', parts, parts)
    return power


def _tapered(fine: Single, wanted: NDArray[np.int64]) -> Single:
    """Return the wanted lines of every taper, (TAPERS, n_lines, n_channels)."""
    tapers = range(1, TAPERS + 1)
    return np.stack([fine[2 * wanted - k] - fine[2 * wanted + k] for k in tapers])


def _ranges(line: NDArray[np.int64], power: Real) -> list[tuple[int, int]]:
    """Return first and last lines of peaks, the most prominent first."""
    level = 10.0 * np.log10(_smooth(line, power) + 1e-30)
    found = prominent_peaks(level, SYNCHRONY.prominence_db)
    ranges: list[tuple[int, int]] = []
    for number in np.argsort(found.prominence)[::-1][:MOST_PEAKS]:
        top, rise = int(found.place[number]), float(found.prominence[number])
        half = float(level[top]) - min(3.0 / rise, 1.0) * rise
        ends = int(found.left[number]), int(found.right[number])
        left, right = crossings(level, top, half, *ends)
        reach = min(max((right - left) / 2.0, 3.0), MOST_LINES_OF_PEAK / 2.0)
        middle = (right + left) / 2.0
        first, last = max(0, round(middle - reach)), round(middle + reach) + 1
        if not any(first < end and last > begin for begin, end in ranges):
            ranges.append((first, last))
    return ranges


def _smooth(line: NDArray[np.int64], power: Real) -> Real:
    """Return the mean power over a width that grows with frequency."""
    smooth = np.empty_like(power)
    width = FEWEST_LINES
    while True:
        wide = line >= width / WIDTH if width > FEWEST_LINES else np.ones(len(line), dtype=bool)
        if not wide.any():
            return smooth
        first = int(np.argmax(wide))
        smooth[first:] = uniform_filter1d(power, width, mode='nearest')[first:]
        width = round(1.25 * width) | 1


def _peak(single: Single, power: Real, line_hz: Real) -> Peak:
    middle = float(np.average(line_hz, weights=power))
    return Peak(middle, line_hz - middle, single)
