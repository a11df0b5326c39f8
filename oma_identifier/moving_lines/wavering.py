"""Lines that waver: too wide to be steady, moving too little to stand out of their own median.

The speed of a spindle that is held is held to a part in a thousand or so.  Its lines are then a
few to some tens of spectral lines wide, as light modes are.  Random force gives a mode an
envelope of random size; a line keeps its size, and its phase tells how it moves.  What proves the
course is what proves every course: other orders are narrow in the shaft's own time, and not in
the samples.

References
----------
Bartlett (1937), doi:10.1098/rspa.1937.0109 (test whether variances are equal);
Jacobsen, Andersen and Brincker (2007), harmonic detection by kurtosis, IOMAC (envelopes).
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter, uniform_filter1d
from scipy.special import gammainc

from modal_core.samples import Samples
from oma_identifier.moving_lines.course import (
    Course,
    few_channels,
    known_course,
    scaled,
)
from oma_identifier.moving_lines.near_band import NearBand
from oma_identifier.moving_lines.thresholds import MOVING
from oma_identifier.spectra import spectral_power

Real = NDArray[np.float64]
AROUND = 8
"""Widths of a peak to both sides that tell what is usual there.  Spares time only: the proof
decides."""
MOST_TRIED = 4
"""Courses, and orders of each, of which the proof is asked."""


def wavering_course(samples: Samples) -> Course | None:
    """Find the course of lines that waver by a few spectral lines and more.

    Returns
    -------
    Course or None
        None: there are none, as far as can be told.
    """
    few = _few(samples)
    rows, rate_hz = scaled(few), samples.sample_rate_hz
    if not rows.size:
        return None
    lines, every = NearBand.of(rows, rate_hz), np.arange(len(rows)) / rate_hz
    possible = []
    for hz, reach_hz in _wide_peaks(rows, rate_hz):
        speed_hz = _steady_envelope(lines, every, hz, reach_hz)
        if speed_hz is None:
            continue
        course = known_course(few, speed_hz, 1.0)
        others = _others(course, float(speed_hz.mean()), samples.duration_s)
        possible += [(course, others)] if others else []
    possible.sort(key=lambda each: (-len(each[1]), each[0].moved))
    for course, others in possible[:MOST_TRIED]:
        if course.gains(few, others[:MOST_TRIED]):
            return course.with_orders_of(samples)
    return None


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


def _steady_envelope(lines: NearBand, every: Real, hz: float, reach_hz: float) -> Real | None:
    """Return the frequency of a line at every time [Hz]; None: its envelope is a mode's."""
    phasor, time = lines.phasor(hz, reach_hz)
    power = np.maximum(np.abs(phasor) ** 2, 1e-30)
    spectrum = np.abs(np.fft.fft(phasor)) ** 2
    n_free = float(spectrum.sum() ** 2 / np.sum(spectrum**2))
    uneven = float(np.log(power.mean()) - np.log(power).mean())
    degrees = n_free - 1.0
    fit = 2.0 * n_free * uneven / (1.0 + (n_free + 1.0) / (6.0 * n_free))
    if gammainc(0.5 * degrees, 0.5 * fit) > MOVING.even_by_chance:
        return None
    course = CubicSpline(time, np.unwrap(np.angle(phasor)))
    within = np.clip(every, time[0], time[-1])
    speed = hz + course.derivative()(within) / (2.0 * np.pi)
    return np.asarray(speed) if speed.min() > 0.0 else None


def _others(course: Course, followed_hz: float, duration_s: float) -> list[float]:
    """Return the orders that were not followed [Hz], the strongest first."""
    reach_hz = MOVING.most_knots / duration_s
    return [hz for hz in course.orders_hz if abs(hz - followed_hz) > reach_hz]
