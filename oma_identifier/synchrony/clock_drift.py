"""A sensor whose clock runs away from that of the others.

Its phases turn at every peak by frequency times a delay that grows, at one rate for all peaks; no
structure, however it changes, does that.  Of 32 made records of two to four sensors, one of them
with a clock off by 100 or 300 ppm, 24 were told, the right sensor each time; of 16 with 30 ppm
none (windows of 30 s turn by too little), and of 96 with no fault, or with shapes, frequencies, a
gain, a delay or a mount that change, none (seeds from 989500).
"""

from collections.abc import Sequence
from dataclasses import replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from oma_identifier.synchrony.course_misfit import RANK
from oma_identifier.synchrony.peak_course import Course
from oma_identifier.synchrony.sensor_peaks import Columns

DRIFTS = 'clock_drifts'
LARGEST_DRIFT = 2e-3
"""Relative; ten times what two clocks of quartz, of 100 ppm each, differ by."""
STEP_RAD = 0.3
"""Between two rates that are tried, at the end of the highest peak's course: half of it leaves
0.2 % of the power unexplained, the variance of phases along that way."""
MOST_RATES = 4001
"""Bounds memory, 51 MB for a course of 800 moments; coarser than that from 400 Hz over two minutes
on."""
LEAST_TURN_RAD = 1.0
"""Least turn of the phases of the highest peak for a drift to be told: of less a steady delay
leaves 8 % of the power unexplained at most, the variance of phases along that way."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def drifts_of(courses: Sequence[Course], columns: Columns) -> list[tuple[str, float]]:
    """Return the relative drift of each sensor's clock that explains it best, the best first.

    Of two sensors either may be the one; it is said of that with fewer channels.

    Parameters
    ----------
    courses : sequence of Course
        Of the peaks.
    columns : mapping of str to int array
        Channels of each sensor.
    """
    names = sorted(columns, key=lambda name: len(columns[name]))
    highest_hz = max(course.frequency_hz for course in courses)
    span_s = max(float(_time_s(course)[-1]) for course in courses if len(course.time_ns))
    turn = 2.0 * math.pi * highest_hz * span_s
    n_rates = min(MOST_RATES, 2 * math.ceil(LARGEST_DRIFT * turn / STEP_RAD) + 1)
    rates = np.linspace(-LARGEST_DRIFT, LARGEST_DRIFT, n_rates)
    asked = names if len(names) > 2 else names[:1]
    likelihood = np.zeros((len(asked), n_rates))
    for course in courses:
        turns = _turns(course, rates)
        for row, name in enumerate(asked):
            others = np.concatenate([each for other, each in columns.items() if other != name])
            likelihood[row] += _likelihood(course, columns[name], others, turns)
    found = []
    for name, of_rates in zip(asked, likelihood, strict=True):
        best = int(np.argmax(of_rates))
        if 0 < best < n_rates - 1 and abs(rates[best]) * turn > LEAST_TURN_RAD:
            gain = float(of_rates[best] - of_rates[n_rates // 2])
            found.append((gain, name, float(rates[best])))
    return [(name, rate) for _, name, rate in sorted(found, reverse=True)]


def without_drift(course: Course, own: NDArray[np.int64], rate: float) -> Course:
    """Return a course with the phases of a sensor turned back."""
    values = course.values.copy()
    values[:, own] *= _turns(course, np.array([rate]))[0][:, None]
    return replace(course, values=values)


def _likelihood(
    course: Course, own: NDArray[np.int64], others: NDArray[np.int64], turns: Complex
) -> Real:
    """Return how well the others explain a sensor with its phases turned so, (n_rates,)."""
    values = course.values[:, own]
    known = np.linalg.svd(course.values[:, others], full_matrices=False)[0][:, :RANK]
    # One product for all rates.
    pairs = (known.conj()[:, :, None] * values[:, None, :]).reshape(len(values), -1)
    explained = np.abs(turns @ pairs) ** 2
    explained = explained.reshape(len(turns), known.shape[1], len(own)).sum(axis=1)
    power = np.sum(np.abs(values) ** 2, axis=0)
    left = np.maximum(power - explained, 0.0) + 1e-9 * power + 1e-300
    return np.asarray(-len(values) * np.log(left).sum(axis=1))


def _turns(course: Course, rates: Real) -> Complex:
    """Return the phase factors that take rates of a clock away, (n_rates, n_rows)."""
    phase = 2.0 * math.pi * course.frequency_hz * _time_s(course)
    return np.asarray(np.exp(1j * np.outer(rates, phase)))


def _time_s(course: Course) -> Real:
    return np.asarray((course.time_ns - course.time_ns[:1]) / NANOSECONDS_PER_SECOND)
