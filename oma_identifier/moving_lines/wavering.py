"""Lines that waver: too wide to be steady, moving too little to stand out of their own median.

The speed of a spindle that is held is held to a part in a thousand or so.  Its lines are then a
few to some tens of spectral lines wide, as light modes are.  Random force gives a mode an
envelope of random size; a line keeps its size, and its phase tells how it moves.

What proves the course is another order: turned back by the phase that the first one tells, less of
it is left beside a constant phasor.  A phase that has nothing to do with it adds to what is left.
To first order it can take from the rest what one real coefficient explains, and how much that is
of a rest that is random is a matter of Fisher's test.

References
----------
Bartlett (1937), doi:10.1098/rspa.1937.0109 (test whether variances are equal);
Jacobsen, Andersen and Brincker (2007), harmonic detection by kurtosis, IOMAC (envelopes).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct, idct
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter, uniform_filter1d
from scipy.special import gammainc

from modal_core.numbers.chance import fisher_tail
from modal_core.samples import Samples
from oma_identifier.moving_lines.course import baseband, Course, few_channels, known_course, scaled
from oma_identifier.moving_lines.near_band import NearBand
from oma_identifier.moving_lines.refined import refined
from oma_identifier.moving_lines.thresholds import MOVING
from oma_identifier.spectra import spectral_power

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
AROUND = 8
"""Widths of a peak to both sides that tell what is usual there.  Spares time only: the proof
decides."""
N_CENTRED, CENTRED = 6, 1e-3
"""Rounds that find the middle of a peak, and the spectral lines that they may leave it off."""
PADDED = 8
"""Times its length to which a stretch is filled up, to find its strongest frequency."""
FEWEST_FREE = 2.0
"""Free values of an envelope below which it does not tell a line from a mode."""
N_REFINED = 2
"""Rounds in which all orders together correct the course that one of them told."""
APART = 1.5
"""Sums of their half-widths by which two peaks must differ to be two."""


@dataclass(frozen=True)
class _Peak:
    """What is near a frequency, turned back by it: phasors and their phases, in time."""

    hz: float
    reach_hz: float
    phasor: Complex
    time: Real

    @cached_property
    def phase(self) -> CubicSpline:
        return CubicSpline(self.time, np.unwrap(np.angle(self.phasor)))


def wavering_course(samples: Samples) -> Course | None:
    """Find the course of lines that waver by a spectral line and more.

    Returns
    -------
    Course or None
        None: there are none, as far as can be told.
    """
    few = _few(samples)
    rows, rate_hz = scaled(few), samples.sample_rate_hz
    if not rows.size:
        return None
    near = NearBand.of(rows, rate_hz)
    peaks = [_centred(near, *each) for each in _wide_peaks(rows, rate_hz)]
    asked = [
        (one, other)
        for one in peaks
        if _is_even(one.phasor)
        for other in peaks
        if abs(one.hz - other.hz) > APART * (one.reach_hz + other.reach_hz)
    ]
    best, followed = MOVING.wrong_course / max(1, len(asked)), None
    for one, other in asked:
        chance = _chance(one, other)
        if chance < best:
            best, followed = chance, one
    if followed is None:
        return None
    every = np.clip(np.arange(len(rows)) / rate_hz, followed.time[0], followed.time[-1])
    speed_hz = followed.hz + _clear_phase(followed).derivative()(every) / (2.0 * np.pi)
    if not speed_hz.min() > 0.0:
        return None
    course = known_course(few, speed_hz, 1.0)
    for _ in range(N_REFINED):
        course = refined(course, few)
    return course.with_orders_of(samples)


def _few(samples: Samples) -> Samples:
    chosen = few_channels(samples)
    return replace(
        samples,
        acceleration=samples.widened(columns=chosen),
        channels=tuple(samples.channels[index] for index in chosen),
    )


def _wide_peaks(rows: Real, rate_hz: float) -> list[tuple[float, float]]:
    """Return frequency and half-width of what stands out over several widths [Hz]."""
    spacing_hz = rate_hz / len(rows)
    power = spectral_power(rows).sum(axis=1).astype(np.float64)
    found, width = [], MOVING.narrowest_waver
    highest = int(MOVING.highest * len(rows))
    while width < MOVING.widest_waver * highest:
        level = uniform_filter1d(power, width)
        step = max(1, width // 4)
        usual = np.repeat(median_filter(level[::step], 2 * AROUND * width // step + 1), step)
        ratio = level / np.maximum(usual[: len(level)], np.finfo(float).tiny)
        here = np.arange(len(ratio))
        ratio[(here < width / MOVING.widest_waver) | (here < 2 * width) | (here > highest)] = 0.0
        for _ in range(MOVING.wavers_tried):
            at = int(np.argmax(ratio))
            if ratio[at] < MOVING.waver_stands_out:
                break
            found.append((at * spacing_hz, width * spacing_hz))
            ratio[max(0, at - 2 * width) : at + 2 * width + 1] = 0.0
        width *= 2
    return found


def _centred(near: NearBand, hz: float, reach_hz: float) -> _Peak:
    """Return a peak turned back by the mean frequency of its strongest part."""
    seen, seen_s = near.around(hz, reach_hz)
    rate_hz, middle_hz = 1.0 / float(seen_s[1] - seen_s[0]), hz
    for number in range(N_CENTRED):
        turn = 2.0 * np.pi * (hz - middle_hz) * seen_s
        slow, time = baseband(seen[:, None], turn, rate_hz, reach_hz)
        phasor, step_s = slow[:, 0], float(time[1] - time[0])
        half = len(phasor) // 2
        taper = np.hanning(half)
        if number == 0:
            spectrum = np.abs(np.fft.fft(phasor * np.hanning(len(phasor)), PADDED * len(phasor)))
            off_hz = np.fft.fftfreq(len(spectrum), step_s)[np.argmax(spectrum)]
        else:
            turned = np.vdot(taper @ phasor[:half], taper @ phasor[-half:])
            off_hz = np.angle(turned) / (2.0 * np.pi * (len(phasor) - half) * step_s)
        if abs(off_hz) * near.n_rows < CENTRED * near.rate_hz:
            break
        hz += float(off_hz)
    return _Peak(hz, reach_hz, phasor, time + seen_s[0])


def _clear_phase(peak: _Peak) -> CubicSpline:
    """Return the phase of a peak as far as it is worth its cost (Schwarz) [rad].

    Its size tells the noise.  Noise that were left in would turn lines that are stronger, and what
    is then taken of them has it.
    """
    level = dct(np.unwrap(np.angle(peak.phasor)), norm='ortho')
    size = dct(np.log(np.maximum(np.abs(peak.phasor), 1e-30)), norm='ortho')
    worth = np.cumsum(level**2 / np.mean(size[1:] ** 2) - np.log(len(level)))
    level[int(np.argmax(worth)) + 1 :] = 0.0
    return CubicSpline(peak.time, idct(level, norm='ortho'))


def _is_even(phasor: Complex) -> bool:
    """Tell whether an envelope is more even than a mode's, or does not tell."""
    power = np.maximum(np.abs(phasor) ** 2, 1e-30)
    n_free = _n_free(phasor)
    uneven = float(np.log(power.mean()) - np.log(power).mean())
    fit = 2.0 * n_free * uneven / (1.0 + (n_free + 1.0) / (6.0 * n_free))
    chance = gammainc(0.5 * (n_free - 1.0), 0.5 * fit)
    return bool(n_free < FEWEST_FREE or chance < MOVING.even_by_chance)


def _n_free(phasor: Complex) -> float:
    spectrum = np.abs(np.fft.fft(phasor)) ** 2
    return float(spectrum.sum() ** 2 / np.sum(spectrum**2))


def _chance(one: _Peak, other: _Peak) -> float:
    """Return the chance that the phase of a peak takes so much from the rest beside another."""
    within = np.clip(other.time, one.time[0], one.time[-1])
    turned = np.exp(-1j * other.hz / one.hz * one.phase(within)) * other.phasor
    before, after = _rest(other.phasor), _rest(turned)
    share = 1.0 - np.sum(np.abs(after) ** 2) / np.sum(np.abs(before) ** 2)
    n_free = 2.0 * _n_free(after) - 1.0
    if not (share > 0.0 and n_free > 0.0):
        return 1.0
    return 0.5 * float(fisher_tail(n_free * share / (1.0 - share), 1.0, n_free))


def _rest(phasor: Complex) -> Complex:
    """Return what is left beside a constant phasor, at the frequency that leaves least."""
    middle = np.linspace(-1.0, 1.0, len(phasor))
    strongest = np.argmax(np.abs(np.fft.fft(phasor, PADDED * len(phasor)))) / PADDED
    phasor = phasor * np.exp(-2j * np.pi * strongest / len(phasor) * np.arange(len(phasor)))
    for _ in range(N_CENTRED):
        mean = phasor.mean()
        drift = 1j * mean * middle
        slope = np.vdot(drift, phasor - mean).real / np.vdot(drift, drift).real
        phasor = phasor * np.exp(-1j * slope * middle)
    return np.asarray(phasor - phasor.mean())
