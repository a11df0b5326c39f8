"""How the speed of a shaft runs over a record: all its orders move by the same factor.

A line that moves stands out, in a spectrogram, of what is usual at its frequency; modes and lines
of constant frequency are usual at theirs.  The best path through the spectrogram is followed more
precisely by the phase of the line, demodulated by the path, and what is left over is a spline in
time.  In the shaft's own time, in which it turns evenly, all orders are lines of constant
frequency.  They are narrow there, and not in the samples: that is what proves a course.

References
----------
Vold and Leuridan (1993), SAE Technical Paper 931288, doi:10.4271/931288 (order tracking);
Forney (1973), doi:10.1109/PROC.1973.9030 (best path).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import logging
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct, idct, next_fast_len, rfft
from scipy.interpolate import BSpline, CubicSpline, make_lsq_spline

from modal_core.samples import Samples
from oma_identifier.moving_lines.thresholds import MOVING
from oma_identifier.spectra import Line, line_at, narrow_peaks_hz, SPECTRA

log = logging.getLogger(__name__)
Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
WIDEST_STEP, PRICE = 2, 0.3
"""Bins by which a path may move from frame to frame, and what a bin costs."""
MOST_CHANNELS = 6
"""That tell the course; amplitudes are those of all."""
LEAST_FRAME, FEWEST_FRAMES = 64, 16
MEASURED_FRAME_S = 4.0
"""A measured speed is right to 4 / this [Hz] at the line that corrects it."""
MEASURED_LEAST = 1e-5
"""Share of the speed that no tachometer tells better."""
LEAST_VALUES = 2
"""Of a measured speed per knot of its course: with fewer a knot is not told."""
CLIP = (-3.0, 6.0)
"""Of the logarithm of power: no frame decides alone."""


@dataclass(frozen=True, slots=True)
class Course:
    """A shaft's own time, and its orders.

    Parameters
    ----------
    own_time_s : (n_samples,) array [s]
        Time in which the shaft turns evenly, from 0 to the end of the record.
    orders_hz : tuple of float [Hz]
        Mean frequencies of lines that stand still in it.
    moved : float
        From the lowest to the highest speed over the mean.
    least_lines : float
        Spectral lines that an order must move to be one of its orders.
    base_hz : float [Hz]
        Mean speed of the shaft where it is measured, 0: it is not known.
    """

    own_time_s: Real
    orders_hz: tuple[float, ...]
    moved: float
    least_lines: float = MOVING.moved
    base_hz: float = 0.0

    def with_orders_of(self, samples: Samples) -> 'Course':
        """Return the course with the orders that samples show, the strongest first."""
        least_hz = self.least_hz(samples.duration_s)
        highest_hz = MOVING.highest * samples.sample_rate_hz
        if not least_hz < highest_hz:
            return replace(self, orders_hz=())
        still = self.standing_still(samples)
        seen = tuple(hz for hz in narrow_peaks_hz(still) if least_hz < hz < highest_hz)
        return replace(self, orders_hz=seen)

    def least_hz(self, duration_s: float) -> float:
        """Return the mean frequency from where on an order moves enough to be told [Hz]."""
        return self.least_lines / (self.moved * duration_s)

    def has_lines_of(self, samples: Samples) -> bool:
        """Tell whether an order keeps its phase as a line does, and modes that drift do not."""
        still = self.standing_still(samples)
        return any(_stands_out(line_at(still, hz)) for hz in self.orders_hz)

    def gains(self, samples: Samples, orders_hz: Sequence[float]) -> bool:
        """Tell whether more of a line is coherent in the shaft's own time than in the samples."""
        still = self.standing_still(samples)
        return any(
            _stands_out(own := line_at(still, hz))
            and _power(own) > MOVING.coherent * _power(line_at(samples, hz))
            for hz in orders_hz
        )

    def standing_still(self, samples: Samples) -> Samples:
        """Return samples at even steps of the shaft's own time."""
        even = np.arange(len(self.own_time_s)) / samples.sample_rate_hz
        when = np.interp(even, self.own_time_s, even)
        still = np.empty(samples.acceleration.shape)
        # One by one: a spline has four numbers for every sample.
        for column, rows in enumerate(samples.widened().T):
            still[:, column] = CubicSpline(even, rows)(when)
        return replace(samples, acceleration=still)


def _stands_out(line: Line) -> bool:
    return line.stands_out(SPECTRA.line_chance, SPECTRA.sure_line)


def _power(line: Line) -> float:
    return float(np.sum(np.abs(line.shape) ** 2))


def find_course(samples: Samples) -> Course | None:
    """Find the lines that move most clearly.

    Parameters
    ----------
    samples : Samples
        Responses.

    Returns
    -------
    Course or None
        None: no line moves, as far as can be told.
    """
    rows, rate_hz = scaled(samples), samples.sample_rate_hz
    if not rows.size or len(rows) < LEAST_FRAME * FEWEST_FRAMES:
        return None
    time, path_hz, frame_s, clear = _ridge(rows, rate_hz)
    log.debug('best ridge: %.3g, %.3g to %.3g Hz', clear, path_hz.min(), path_hz.max())
    if clear < MOVING.ridge:
        return None
    for n_knots in MOVING.steps:
        speed_hz = _followed(rows, rate_hz, time, path_hz, frame_s, n_knots)
        # NaN where the spline has too few values.
        if not (speed_hz.min() > 0.0 and np.ptp(speed_hz) < MOVING.sweep * speed_hz.mean()):
            continue
        course = known_course(samples, speed_hz)
        far = MOVING.far * n_knots / (len(rows) / rate_hz)
        enough = len(course.orders_hz) > 1 or np.ptp(speed_hz) > far
        if enough and course.has_lines_of(samples):
            return course
    return None


def measured_course(samples: Samples) -> Course | None:
    """Return the course of the spindle's measured speed.

    Returns
    -------
    Course or None
        None: no speed is known, it does not move, or no line moves with it.
    """
    rate_hz, n_rows = samples.sample_rate_hz, len(samples.acceleration)
    if samples.speed is None or n_rows < LEAST_FRAME:
        return None
    speed_hz = samples.speed.at(samples.start_ns, rate_hz, n_rows)
    if speed_hz is None:
        return None
    speed_hz, n_knots = _plain_course(speed_hz, rate_hz, len(samples.speed.stamp_ns))
    # A line at half the sample rate would have to move by one spectral line.
    if not np.ptp(speed_hz) * n_rows > 2.0 * speed_hz.mean():
        return None
    mean_hz = float(speed_hz.mean())
    course = known_course(samples, speed_hz, 1.0)
    if course.orders_hz:
        line_hz = speed_hz * course.orders_hz[0] / mean_hz
        knots = min(n_knots, MOVING.steps[-1])
        turning = _corrected(scaled(samples), rate_hz, line_hz, MEASURED_FRAME_S, knots)
        finer = known_course(samples, turning, 1.0)
        course = finer if len(finer.orders_hz) > len(course.orders_hz) else course
    if not course.has_lines_of(samples):
        return None
    return replace(course, base_hz=mean_hz)


def _plain_course(speed_hz: Real, rate_hz: float, n_values: int) -> tuple[Real, int]:
    """Return a measured speed without its noise, and the knots of that course (Schwarz).

    Of a steady shaft it is constant, without knots.
    """
    time, every = np.arange(len(speed_hz)) / rate_hz, []
    steps = [*MOVING.steps]
    while 2 * LEAST_VALUES * steps[-1] <= n_values:
        steps.append(2 * steps[-1])
    for n_knots in (0, *steps):
        course = np.full(len(time), speed_hz.mean())
        if n_knots:
            ones = np.ones(len(time))
            course = smooth(time, speed_hz, ones, (0.0, time[-1]), n_knots)(time)
        left = np.mean((speed_hz - course) ** 2) + (MEASURED_LEAST * speed_hz.mean()) ** 2
        price = n_values * np.log(left) + n_knots * np.log(n_values)
        every.append((price, n_knots, course))
    _, n_knots, course = min(every, key=lambda each: each[:2])
    return course, n_knots


def known_course(samples: Samples, speed_hz: Real, least_lines: float = MOVING.moved) -> Course:
    """Return the course of a known speed, and the orders that are seen.

    Parameters
    ----------
    samples : Samples
        Responses.
    speed_hz : (n_samples,) array [Hz]
        Above zero; any multiple of the speed does.
    least_lines : float
        As for :class:`Course`.
    """
    rate_hz, n_rows = samples.sample_rate_hz, len(speed_hz)
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (speed_hz[1:] + speed_hz[:-1]))])
    own = turned * (n_rows - 1) / rate_hz / turned[-1]
    course = Course(own, (), float(np.ptp(speed_hz) / speed_hz.mean()), least_lines)
    return course.with_orders_of(samples)


def few_channels(samples: Samples) -> NDArray[np.intp]:
    """Return which channels tell, spread over all."""
    n_channels = len(samples.channels)
    return np.linspace(0, n_channels - 1, min(n_channels, MOST_CHANNELS)).round().astype(np.intp)


def scaled(samples: Samples) -> Real:
    """Return a few channels that move, without offset and of unit root mean square."""
    rows = samples.widened(columns=few_channels(samples))
    rows = rows - rows.mean(axis=0)
    size = rows.std(axis=0)
    return np.asarray(rows[:, size > 0.0] / size[size > 0.0])


def _ridge(rows: Real, rate_hz: float) -> tuple[Real, Real, float, float]:
    """Return times [s] and frequencies [Hz] of the best path, length of a frame [s], clearness."""
    duration_s = len(rows) / rate_hz
    fastest_hz = MOVING.widest_change * MOVING.highest * rate_hz
    length = int(np.sqrt(duration_s / fastest_hz) * rate_hz)
    length = max(LEAST_FRAME, min(length, len(rows) // FEWEST_FRAMES))
    starts = np.arange(0, len(rows) - length + 1, max(1, length // 4))
    taper, padded = np.hanning(length)[:, None], next_fast_len(2 * length, real=True)
    power = np.stack(
        [
            np.sum(np.abs(rfft(rows[first : first + length] * taper, padded, axis=0)) ** 2, 1)
            for first in starts
        ]
    )
    hz = np.arange(power.shape[1]) * rate_hz / padded
    level = np.log(np.maximum(power, np.finfo(float).tiny))
    level -= np.median(level, axis=0)
    level -= np.median(level, axis=1)[:, None]
    level = np.clip(level, *CLIP)
    # The lowest bins hold what is slower than a frame.
    level[:, (hz < 2.0 * rate_hz / length) | (hz > MOVING.highest * rate_hz)] = CLIP[0]
    path, clear = _best_path(level)
    time = np.asarray((starts + 0.5 * length) / rate_hz, dtype=np.float64)
    return time, hz[path], length / rate_hz, clear


def _best_path(level: Real) -> tuple[NDArray[np.int64], float]:
    """Return the bins, frame by frame, of the path with the largest sum, and its mean."""
    n_frames, n_bins = level.shape
    steps = np.arange(-WIDEST_STEP, WIDEST_STEP + 1)
    best, back = level[0].copy(), np.zeros((n_frames, n_bins), dtype=np.int8)
    for frame in range(1, n_frames):
        come = np.full((len(steps), n_bins), -np.inf)
        for row, step in enumerate(range(-WIDEST_STEP, WIDEST_STEP + 1)):
            low, high = max(0, -step), min(n_bins, n_bins - step)
            come[row, low:high] = best[low + step : high + step] - PRICE * abs(step)
        chosen = come.argmax(axis=0)
        back[frame] = steps[chosen]
        best = come[chosen, np.arange(n_bins)] + level[frame]
    path = np.empty(n_frames, dtype=np.int64)
    path[-1] = best.argmax()
    for frame in range(n_frames - 1, 0, -1):
        path[frame - 1] = path[frame] + back[frame, path[frame]]
    return path, float(best.max() / n_frames)


def _followed(
    rows: Real, rate_hz: float, time: Real, path_hz: Real, frame_s: float, n_knots: int
) -> Real:
    """Return the frequency of the line at every sample [Hz], corrected by its phase."""
    every = np.arange(len(rows)) / rate_hz
    span = time[0], time[-1]
    coarse = smooth(time, path_hz, np.ones(len(time)), span, min(n_knots, len(time) // 4))
    within = np.clip(every, *span)
    speed = coarse(within) + (every - within) * coarse.derivative()(within)
    return _corrected(rows, rate_hz, speed, frame_s, n_knots)


def _corrected(rows: Real, rate_hz: float, speed: Real, frame_s: float, n_knots: int) -> Real:
    """Return the frequency of a line at every sample [Hz], corrected by its phase."""
    every = np.arange(len(rows)) / rate_hz
    for reach_hz in (4.0 / frame_s, 2.0 / frame_s, 1.0 / frame_s):
        turn = 2.0 * np.pi * np.cumsum(speed) / rate_hz
        slow, at = baseband(rows, turn, rate_hz, reach_hz)
        step = np.sum(slow[1:] * slow[:-1].conj(), axis=1)
        off_hz = np.angle(step) / (2.0 * np.pi * (at[1] - at[0]))
        weight = np.sqrt(np.abs(step) / np.abs(step).max() + 1e-6)
        middle = 0.5 * (at[1:] + at[:-1])
        off = smooth(middle, off_hz, weight, (0.0, every[-1]), n_knots)
        speed = speed + off(every)
    return np.asarray(speed)


def smooth(
    time: Real, values: NDArray[Any], weight: Real, span: tuple[float, float], n_knots: int
) -> BSpline:
    """Return the cubic spline of so many knots within the span that fits values best."""
    first, last = min(span[0], time[0]), max(span[1], time[-1])
    inner = np.linspace(first, last, n_knots + 2)[1:-1]
    return make_lsq_spline(time, values, np.r_[[first] * 4, inner, [last] * 4], 3, w=weight)


def baseband(
    rows: Real | Complex, turn: Real, rate_hz: float, reach_hz: float
) -> tuple[Complex, Real]:
    """Return rows turned back by a phase, of frequencies within a reach, and its times [s].

    Parameters
    ----------
    rows : (n_samples, n_channels) array
        Real or complex.
    turn : (n_samples,) array [rad]
        Phase.
    rate_hz, reach_hz : float [Hz]
        Of the rows; half the band that is kept.

    Returns
    -------
    slow : (n_slow, n_channels) complex array
        Half the amplitude of a line at that phase.
    time : (n_slow,) array [s]
    """
    level = cosine_coefficients(np.exp(-1j * turn)[:, None] * rows)
    n_kept = min(len(rows), max(16, int(2.0 * reach_hz * len(rows) / rate_hz)))
    n_slow = 2 * n_kept
    slow = np.zeros((n_slow, rows.shape[1]), dtype=complex)
    taper = np.cos(0.5 * np.pi * np.arange(n_kept) / n_kept) ** 2
    slow[:n_kept] = taper[:, None] * level[:n_kept]
    time = ((np.arange(n_slow) + 0.5) * len(rows) / n_slow - 0.5) / rate_hz
    return from_cosines(slow) * np.sqrt(n_slow / len(rows)), time


def cosine_coefficients(rows: Complex) -> Complex:
    """Return the orthonormal cosine coefficients of complex rows; of half periods each."""
    return np.asarray(
        dct(rows.real, axis=0, norm='ortho') + 1j * dct(rows.imag, axis=0, norm='ortho')
    )


def from_cosines(level: Complex) -> Complex:
    """Return the rows of coefficients."""
    real, imaginary = (idct(part, axis=0, norm='ortho') for part in (level.real, level.imag))
    return np.asarray(real + 1j * imaginary)
