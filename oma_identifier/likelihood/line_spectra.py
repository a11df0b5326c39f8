"""Discrete Fourier transforms of all channels of a stretch, and which lines of them to use."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft

from modal_core.mode import Mode
from modal_core.samples import Samples
from oma_identifier.likelihood.thresholds import LIKELIHOOD

CHANNELS_AT_ONCE, VALUES_AT_ONCE = 4, 1 << 18
FEW_ROWS = 64


@dataclass(frozen=True, slots=True)
class Spectra:
    """Discrete Fourier transforms of all channels.

    Parameters
    ----------
    sample_rate_hz : float [Hz]
        Of the samples.
    frequency_hz : (n_frequencies,) array [Hz]
        From 0; of several stretches all their lines, by frequency.
    values : (n_channels, n_frequencies) complex64 array
        Scaled by one over the square root of the number of samples.  Single precision: its
        rounding is 1e-7 of a channel's motion, less than any sensor resolves.
    durations_s : tuple of float [s]
        Of the stretches; the lines of each are one over its duration apart.
    stretch : (n_frequencies,) int array
        Which of them each line is of.
    """

    sample_rate_hz: float
    frequency_hz: NDArray[np.float64]
    values: NDArray[np.complex64]
    durations_s: tuple[float, ...]
    stretch: NDArray[np.intp]

    @property
    def spacing_hz(self) -> float:
        """Distance of neighbouring frequencies of the shortest stretch [Hz]."""
        return 1.0 / min(self.durations_s)

    def parts(self, lines: NDArray[np.intp]) -> Iterator[tuple[slice, NDArray[np.float64]]]:
        """Yield some lines at a time: which of them, and their real and imaginary parts in turn.

        Each (n_channels, 2 n_lines).  What is real costs half as much on them as on complex
        values; sums over many lines need double precision.
        """
        for here in self.stretches(len(lines)):
            yield here, self.at(lines[here]).astype(np.complex128).view(np.float64)

    def combined(
        self, weights: NDArray[np.float64], lines: NDArray[np.intp]
    ) -> NDArray[np.complex128]:
        """Return combinations of the channels, (n_channels, n) weights, as (n, n_lines)."""
        found = [weights.T @ parts for _, parts in self.parts(lines)]
        return np.concatenate(found, axis=1).view(np.complex128)

    def along(self, weights: NDArray[np.complex128], lines: slice) -> NDArray[np.complex128]:
        """Return one combination of the channels, (n_channels,) weights, at (n_lines,) lines."""
        values = self.values[:, lines]
        return np.concatenate([weights @ values[:, h] for h in self.stretches(values.shape[1])])

    def stretches(self, n_lines: int) -> Iterator[slice]:
        """Yield so many lines in stretches: what is made of all channels may not be large."""
        at_once = max(1, VALUES_AT_ONCE // len(self.values))
        for first in range(0, n_lines, at_once):
            yield slice(first, min(first + at_once, n_lines))

    def at(self, lines: NDArray[np.intp]) -> NDArray[np.complex64]:
        """Return the values at some lines, not copied where no line is left out between."""
        if len(lines) and lines[-1] - lines[0] == len(lines) - 1:
            return self.values[:, lines[0] : lines[-1] + 1]
        return np.take(self.values, lines, axis=1)

    def near(self, frequency_hz: float, reach_hz: float) -> slice:
        """Return the lines within reach of a frequency, one at least, without that at 0.

        Beyond the end of the spectrum, where a fit may lead a mode, that is the last.
        """
        ends = (frequency_hz - reach_hz, frequency_hz + reach_hz)
        first, last = np.searchsorted(self.frequency_hz, ends)
        first = min(max(1, int(first)), len(self.frequency_hz) - 1)
        return slice(first, max(first + 1, int(last)))


def moving_channels(samples: Samples) -> NDArray[np.intp]:
    """Return the channels whose samples are not all equal."""
    data = samples.acceleration
    moves = (data[:FEW_ROWS] != data[:1]).any(axis=0)
    # Nearly always that settles it; only the others need all their samples.
    still = np.flatnonzero(~moves)
    moves[still] = (data[:, still] != data[:1, still]).any(axis=0)
    return np.flatnonzero(moves)


def spectra_of(
    samples: Samples, channels: NDArray[np.intp], more: Sequence[Samples] = ()
) -> Spectra:
    """Return the spectra of some channels, of one stretch or of several between gaps.

    Lines of different stretches are independent values of the same density: to a likelihood they
    are lines of one spectrum, denser where stretches are long.
    """
    found = [_spectra_of(each, channels) for each in (samples, *more)]
    if len(found) == 1:
        return found[0]
    frequency = np.concatenate([each.frequency_hz for each in found])
    order = np.argsort(frequency, kind='stable')
    values = np.take(np.concatenate([each.values for each in found], axis=1), order, axis=1)
    durations_s = tuple(each.durations_s[0] for each in found)
    lengths = [len(each.frequency_hz) for each in found]
    stretch = np.repeat(np.arange(len(found)), lengths)[order]
    return Spectra(samples.sample_rate_hz, frequency[order], values, durations_s, stretch)


def inputs_of(samples: Samples, more: Sequence[Samples] = ()) -> NDArray[np.complex64] | None:
    """Return the transforms of known inputs, (n_inputs, n_frequencies); None: none are known.

    At the frequencies of :func:`spectra_of`.
    """
    found = []
    for each in (samples, *more):
        if each.known is None or not np.isfinite(each.known).all():
            return None
        found.append(replace(each, acceleration=each.known, known=None))
    return spectra_of(found[0], np.arange(found[0].acceleration.shape[1]), found[1:]).values


def _spectra_of(samples: Samples, channels: NDArray[np.intp]) -> Spectra:
    """Return the spectra of one stretch, freed of offset and trend.

    A few channels at a time, so that little memory is needed beside the spectra.
    """
    data = samples.acceleration
    n_samples, length = len(data), _fast_length(len(data))
    time = np.arange(n_samples) - 0.5 * (n_samples - 1)
    time /= np.linalg.norm(time)
    values = np.empty((len(channels), length // 2 + 1), dtype=np.complex64)
    for first in range(0, len(channels), CHANNELS_AT_ONCE):
        chosen = channels[first : first + CHANNELS_AT_ONCE]
        if chosen[-1] - chosen[0] == len(chosen) - 1:
            rows = np.array(data[:, chosen[0] : chosen[-1] + 1].T, np.float64, order='C')
        else:
            rows = np.array(data[:, chosen].T, np.float64, order='C')
        for row in rows:
            row -= row.mean() + (row @ time) * time
        single = rows[:, :length].astype(np.float32)
        values[first : first + len(chosen)] = rfft(single, axis=1, norm='ortho')
    frequency = np.arange(values.shape[1]) * samples.sample_rate_hz / length
    duration_s = length / samples.sample_rate_hz
    only = np.broadcast_to(np.intp(0), len(frequency))
    return Spectra(samples.sample_rate_hz, frequency, values, (duration_s,), only)


def _fast_length(n_samples: int) -> int:
    """Return a length at most 0.5 % shorter that the transform likes; padding would correlate."""
    for shorter in range(n_samples, n_samples - max(1, n_samples // 200), -1):
        if next_fast_len(shorter, real=True) == shorter:
            return shorter
    return n_samples


def usable_lines(spectra: Spectra, harmonics: Iterable[Mode]) -> NDArray[np.bool_]:
    """Return which lines to use: neither 0 nor near Nyquist's frequency nor near a harmonic."""
    frequency = spectra.frequency_hz
    usable = (frequency > 0.0) & (frequency <= LIKELIHOOD.highest_share * spectra.sample_rate_hz)
    reach_hz = LIKELIHOOD.line_reach * spectra.spacing_hz
    for line in harmonics:
        usable &= np.abs(frequency - line.frequency_hz) > reach_hz
    return np.asarray(usable)
