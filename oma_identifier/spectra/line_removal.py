"""Sinusoids taken out of samples, so that what is left is the response to random forces."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples
from oma_identifier.spectra.sinusoids import fit_sinusoids

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
    to_turn = 2.0 * np.pi / samples.sample_rate_hz
    near = to_turn * np.array([_refined(samples, frequency, time) for frequency in frequencies_hz])
    rows = samples.acceleration
    lines = fit_sinusoids(rows, near)
    # The best place searched is a step away at most: further on there is no line, but a mode.
    step = to_turn * 2.0 * REACH / (N_OFFSETS - 1) / samples.duration_s
    if np.any(strayed := np.abs(lines.turn - near) > step):
        lines = fit_sinusoids(rows, np.where(strayed, near, lines.turn), n_rounds=0)
    return replace(samples, acceleration=lines.taken_from(rows))


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
