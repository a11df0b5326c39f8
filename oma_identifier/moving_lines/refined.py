"""A course that all orders tell together, each as far as it is clear.

In the own time τ of a shaft whose course is off by ε(τ), the order of frequency f is
c exp(2πi f (τ + ε)), to first order c (1 + 2πi f ε): its coefficients beside the first one are in
quadrature to that, and what is in phase with it tells how much is noise.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples
from oma_identifier.moving_lines.course import Course, from_cosines, scaled
from oma_identifier.moving_lines.near_band import NearBand
from oma_identifier.moving_lines.thresholds import MOVING

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
N_CENTRED = 3
SLOPE = -0.5554
"""Spectral lines by which a frequency is off whose phase has a second coefficient of one."""


def refined(course: Course, samples: Samples) -> Course:
    """Return a course that all orders found agree on best."""
    still = course.standing_still(samples)
    near = NearBand.of(scaled(still), samples.sample_rate_hz)
    seen = [(hz, *_told(near, hz)) for hz in course.orders_hz]
    if not seen:
        return course
    rate = np.array([2.0 * np.pi * hz for hz, _, _ in seen])
    noise = np.array([noise for _, _, noise in seen])
    weight = rate / noise
    off = weight @ np.stack([phase for _, phase, _ in seen]) / (weight @ rate)
    worth = np.cumsum(off**2 * (weight @ rate) - np.log(len(off)))
    n_kept = int(np.argmax(worth)) + 1 if worth.max() > 0.0 else 0
    level = np.zeros((near.n_rows, 1), dtype=complex)
    level[1 : n_kept + 1, 0] = off[:n_kept] * np.sqrt(near.n_rows)
    correction = from_cosines(level)[:, 0].real
    time = np.arange(near.n_rows) / near.rate_hz
    own = course.own_time_s + np.interp(course.own_time_s, time, correction)
    return replace(course, own_time_s=own).with_orders_of(samples)


def _told(near: NearBand, hz: float) -> tuple[Real, float]:
    """Return the phase that an order is off by, in coefficients [rad], and the power of its noise.

    The coefficients are those of a mean square of one over the record.
    """
    for _ in range(N_CENTRED):
        level = near.coefficients(hz, 2 * MOVING.most_knots)
        power = np.mean(np.abs(level[MOVING.most_knots :]) ** 2, axis=0)
        first = level[0] / np.maximum(power, np.finfo(float).tiny)
        told = level @ first.conj() / np.vdot(first, level[0]).real
        # A frequency that is off turns the phase evenly: of that the second coefficient is most.
        hz += float(told[1].imag) * SLOPE * near.rate_hz / near.n_rows
    return told[1:].imag, float(np.mean(told[1:].real ** 2))
