"""Sinusoids taken out of samples, so that what is left is the response to random forces."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples

N_CHUNKS = 64
N_OFFSETS = 81
REACH = 1.0
"""Frequencies are searched this far to both sides, in units of one over the duration."""


def without_lines(samples: Samples, frequencies_hz: Sequence[float]) -> Samples:
    """Return samples less the sinusoids that fit best near the given frequencies.

    Parameters
    ----------
    samples : Samples
        With lines of constant frequency and amplitude.
    frequencies_hz : sequence of float [Hz]
        Within one over the duration.
    """
    if not len(frequencies_hz):
        return samples
    time = np.arange(len(samples.acceleration)) / samples.sample_rate_hz
    exact = [_refined(samples, frequency, time) for frequency in frequencies_hz]
    angle = 2.0 * np.pi * np.outer(time, exact)
    waves = np.concatenate([np.cos(angle), np.sin(angle), np.ones((len(time), 1))], axis=1)
    products = np.zeros((waves.shape[1], len(samples.channels)))
    for rows, part in _stretches(samples):
        products += waves[rows].T @ part
    weights = np.linalg.lstsq(waves.T @ waves, products, rcond=None)[0]
    # As precise as the samples came.
    left = np.empty_like(samples.acceleration)
    for rows, part in _stretches(samples):
        left[rows] = part - waves[rows, :-1] @ weights[:-1]
    return replace(samples, acceleration=left)


def _stretches(samples: Samples) -> Iterator[tuple[slice, NDArray[np.float64]]]:
    first = 0
    for part in samples.stretches():
        yield slice(first, first + len(part)), part
        first += len(part)


def _refined(samples: Samples, frequency_hz: float, time: NDArray[np.float64]) -> float:
    """Return the frequency near the given one at which most power is coherent."""
    length = len(time) // N_CHUNKS
    used = slice(0, N_CHUNKS * length)
    taper = np.hanning(N_CHUNKS * length)
    carrier = (taper * np.exp(-2j * np.pi * frequency_hz * time[used])).reshape(N_CHUNKS, length)
    chunks = np.empty((N_CHUNKS, len(samples.channels)), dtype=complex)
    for number, part in enumerate(carrier):
        rows = samples.widened(slice(number * length, (number + 1) * length))
        chunks[number] = part.real @ rows + 1j * (part.imag @ rows)
    power = np.sum(np.abs(chunks) ** 2, axis=0)
    chunks = chunks / np.sqrt(np.where(power > 0.0, power, 1.0))
    middle = (np.arange(N_CHUNKS) + 0.5) * length / samples.sample_rate_hz
    offsets = np.linspace(-REACH, REACH, N_OFFSETS) / samples.duration_s
    coherent = np.sum(
        np.abs(np.exp(-2j * np.pi * np.outer(offsets, middle)) @ chunks) ** 2, axis=1
    )
    return float(frequency_hz + offsets[int(np.argmax(coherent))])
