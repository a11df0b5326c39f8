"""Tells lines of machines and drives from modes of the structure.

A mode shaken at random forgets its phase within a decay time; a line keeps it for ever.  The
response is demodulated at the suspected frequency over segments of the window: if one constant
phasor explains the segments far better than chance (an F test), it is a line.  This is the
kurtosis and entropy test in its exact form: a line's envelope is constant, a mode's is Rayleigh.

References
----------
Thomson (1982), doi:10.1109/PROC.1982.12433, Section XIII (F test for a line in coloured noise);
Jacobsen, Andersen and Brincker (2007), harmonic detection by kurtosis, IOMAC.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.chance import fisher_tail
from modal_core.samples import Samples

N_SEGMENTS = 12
CHANCE = 1e-6
"""Probability of calling noise a line; about 1,000 suspected frequencies are tested an hour."""
CHANCE_SHARP = 1e-3
"""The same where a pole without any damping repeats over the model orders, itself rare."""
SUSPECT_DAMPING = 0.004
"""Poles damped less than this are suspected lines."""


@dataclass(frozen=True, slots=True)
class Line:
    """A sinusoid in the responses.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Where the phasors of the segments line up best.
    shape : (n_channels,) complex array [m/s²]
        Phasor of each channel.
    chance : float
        Probability that noise looks like this.
    """

    frequency_hz: float
    shape: NDArray[np.complex128]
    chance: float


def line_at(samples: Samples, frequency_hz: float) -> Line:
    """Test for a line near a frequency.

    Parameters
    ----------
    samples : Samples
        Of at least a few hundred periods.
    frequency_hz : float [Hz]
        Suspected; the neighbourhood of one part in the number of segments is searched.

    Returns
    -------
    Line
        Seen from one segment's frequency beside it a line looks like a weaker one: the strongest
        of such images is returned.
    """
    line = _line_near(samples, frequency_hz)
    step_hz = N_SEGMENTS / samples.duration_s
    while line.chance < CHANCE_SHARP:
        images = [_line_near(samples, line.frequency_hz + step) for step in (-step_hz, step_hz)]
        strongest = max(images, key=_size)
        if _size(strongest) <= _size(line):
            break
        line = strongest
    return line


def _size(line: Line) -> float:
    return float(np.linalg.norm(line.shape))


def _line_near(samples: Samples, frequency_hz: float) -> Line:
    phasors = _segment_phasors(samples, frequency_hz)
    duration = samples.duration_s
    # Residual frequency error turns the phasors from segment to segment: undo the best turn.
    offsets = np.linspace(-0.5, 0.5, 101) * N_SEGMENTS / duration
    middle = (np.arange(N_SEGMENTS) + 0.5) * duration / N_SEGMENTS
    turns = np.exp(-2j * np.pi * np.outer(offsets, middle))
    explained = np.sum(np.abs(turns @ phasors) ** 2, axis=1) / N_SEGMENTS
    best = int(np.argmax(explained))
    total = float(np.sum(np.abs(phasors) ** 2))
    rest = max(total - float(explained[best]), 1e-300)
    ratio = (N_SEGMENTS - 2) * float(explained[best]) / rest
    return Line(
        frequency_hz=float(frequency_hz + offsets[best]),
        shape=np.asarray(turns[best] @ phasors / N_SEGMENTS, dtype=complex),
        # One complex phasor and one frequency were fitted to the segments.
        chance=float(fisher_tail(ratio, 2, 2 * (N_SEGMENTS - 2))),
    )


def _segment_phasors(samples: Samples, frequency_hz: float) -> NDArray[np.complex128]:
    """Return (n_segments, n_channels) complex phasors, channels scaled to comparable power."""
    length = len(samples.acceleration) // N_SEGMENTS
    time = np.arange(N_SEGMENTS * length) / samples.sample_rate_hz
    # A taper over each segment keeps strong modes far away out of the phasor.
    taper = np.tile(np.blackman(length + 2)[1:-1], N_SEGMENTS)
    carrier = taper * np.exp(-2j * np.pi * frequency_hz * time)
    carrier = carrier.reshape(N_SEGMENTS, length)
    turned = np.empty((N_SEGMENTS, len(samples.channels)), dtype=complex)
    for number, part in enumerate(carrier):
        rows = samples.widened(slice(number * length, (number + 1) * length))
        turned[number] = part.real @ rows + 1j * (part.imag @ rows)
    mean = samples.acceleration[: len(time)].mean(axis=0, dtype=np.float64)
    turned -= carrier.sum(axis=1)[:, None] * mean
    return np.asarray(turned * (2.0 / (0.42 * length)))
