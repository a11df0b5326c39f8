"""Random pulses: moves of constant acceleration and deceleration at pseudo-random intervals.

Section 4.2 and Figs. 9-10 of Jiao et al. (2025), doi:10.1038/s41598-025-95339-6, with two
additions: the jerk may be limited, and the shape of each pulse may be random too, which smears
the notches a repeated pulse leaves in the spectrum.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.motion.pulse_shape import PulseShape
from excitation_planner.motion.quickest_shape import quickest_shape

Array = NDArray[np.float64]


def _no_travel(displacement: Array) -> float:
    """Stand for an arm whose points may be as fast as they like."""
    del displacement
    return 0.0


@dataclass(frozen=True, slots=True)
class Pulse:
    """One move of the arm.

    Parameters
    ----------
    start_s : float [s]
        When it begins.
    displacement : (n_joints,) array [rad]
        How far each joint goes.
    shape : PulseShape
        Shared by the joints of this move.
    """

    start_s: float
    displacement: Array
    shape: PulseShape

    @property
    def end_s(self) -> float:
        """When it has come to rest [s]."""
        return self.start_s + self.shape.duration_s


@dataclass(frozen=True, slots=True)
class PulseSettings:
    """How random pulses are drawn.

    Parameters
    ----------
    half_range : (n_joints,) array [rad]
        Targets lie within this of the start pose; 0 keeps a joint still.
    peak_velocity, peak_acceleration : (n_joints,) array [rad/s], [rad/s²]
        What a move may use of each joint.
    interval_s : (2,) tuple [s]
        Pseudo-random pauses between moves are uniform in it; the paper's are 0 to 1 s.
    acceleration_fraction : (2,) tuple
        Each move uses a uniform random part of the peak acceleration; (1, 1) as in the paper.
    ramp_s : (2,) tuple [s]
        Log-uniform random time in which acceleration builds up; (0, 0) gives rectangular pulses.
    speed_fraction : (2,) tuple
        Each move uses a uniform random part of the peak velocity and of the point speed.
    point_speed_m_s : float [m/s]
        What the fastest point of the arm may reach.
    point_travel_m : function from (n_joints,) array [rad] to float [m]
        How far the fastest point goes in a move of these angles.
    synchronised : bool
        All joints start and stop together, as MoveAbsJ does; else each has its own pauses.
    least_acceleration, least_jerk : (n_joints,) array [rad/s²], [rad/s³] or None
        Limits a controller that plays the moves cannot be set below: a gentler move is drawn as
        the one it would make of it.
    """

    half_range: Array
    peak_velocity: Array
    peak_acceleration: Array
    interval_s: tuple[float, float] = (0.02, 1.0)
    acceleration_fraction: tuple[float, float] = (1.0, 1.0)
    ramp_s: tuple[float, float] = (0.0, 0.0)
    speed_fraction: tuple[float, float] = (1.0, 1.0)
    point_speed_m_s: float = np.inf
    point_travel_m: Callable[[Array], float] = _no_travel
    synchronised: bool = True
    least_acceleration: Array | None = None
    least_jerk: Array | None = None


def random_pulses(
    settings: PulseSettings,
    duration_s: float,
    sample_period_s: float,
    generator: np.random.Generator,
) -> tuple[Pulse, ...]:
    """Draw moves that fill a duration, stay in the range and end where they began.

    Parameters
    ----------
    settings : PulseSettings
        How to draw.
    duration_s : float [s]
        Time to fill.
    sample_period_s : float [s]
        Moves start on this grid.
    generator : numpy.random.Generator
        Source of all randomness.

    Returns
    -------
    tuple of Pulse
        By start time; empty when not even one move and its return fit.
    """
    n_joints = len(settings.half_range)
    if settings.synchronised:
        groups = [np.ones(n_joints, dtype=bool)]
    else:
        groups = [np.arange(n_joints) == joint for joint in range(n_joints)]
    pulses: list[Pulse] = []
    for group, own in zip(groups, generator.spawn(len(groups)), strict=True):
        if np.any(settings.half_range[group] > 0.0):
            pulses += _train(settings, group, duration_s, sample_period_s, own)
    return tuple(sorted(pulses, key=lambda pulse: pulse.start_s))


def pulse_velocity(pulses: Sequence[Pulse], n_samples: int, sample_period_s: float) -> Array:
    """Sample the velocity of all pulses.

    Returns
    -------
    (n_samples, n_joints) array [rad/s]
        Scaled pulse by pulse so that the samples sum to the displacement exactly.
    """
    velocity = np.zeros((n_samples, len(pulses[0].displacement)))
    for pulse in pulses:
        first = round(pulse.start_s / sample_period_s)
        last = min(n_samples, int(np.ceil(pulse.end_s / sample_period_s)) + 1)
        since_s = np.asarray(np.arange(first, last) * sample_period_s - pulse.start_s)
        unit = pulse.shape.velocity(since_s)
        unit /= np.sum(unit) * sample_period_s
        velocity[first:last] += np.outer(unit, pulse.displacement)
    return velocity


def rectangular_train(
    n_pulses: int, width: int, n_samples: int, generator: np.random.Generator
) -> Array:
    """Return the paper's test signal: unit rectangles at random places (Fig. 10).

    Parameters
    ----------
    n_pulses : int
        How many.
    width : int
        Samples of each; 3 at 1 kHz is the paper's 3 ms.
    n_samples : int
        Length of the signal.
    generator : numpy.random.Generator
        Source of the places; pulses do not overlap.

    Returns
    -------
    (n_samples,) array
        0 or 1.
    """
    free = n_samples - n_pulses * width
    starts = np.sort(generator.integers(0, free + 1, n_pulses)) + width * np.arange(n_pulses)
    signal = np.zeros(n_samples)
    for start in starts:
        signal[start : start + width] = 1.0
    return signal


def _train(
    settings: PulseSettings,
    group: NDArray[np.bool_],
    duration_s: float,
    sample_period_s: float,
    generator: np.random.Generator,
) -> list[Pulse]:
    """Draw one train; its last move returns to the start."""
    pulses: list[Pulse] = []
    way_home: Pulse | None = None
    offset = np.zeros(len(group))
    time_s = sample_period_s
    while True:
        drawn = generator.uniform(-1.0, 1.0, len(group)) * settings.half_range
        target = np.where(group, drawn, 0.0)
        move = Pulse(time_s, target - offset, _draw_shape(settings, target - offset, generator))
        pause_s = generator.uniform(*settings.interval_s)
        # At least one sample of rest, so that the moves can be told apart in the samples.
        next_s = sample_period_s * (np.ceil((move.end_s + pause_s) / sample_period_s) + 1)
        home = Pulse(next_s, -target, _draw_shape(settings, -target, generator))
        if home.end_s > duration_s - sample_period_s:
            return pulses if way_home is None else [*pulses, way_home]
        pulses.append(move)
        way_home, offset, time_s = home, target, next_s


def _draw_shape(
    settings: PulseSettings, displacement: Array, generator: np.random.Generator
) -> PulseShape:
    """Choose the time course of one move, such that who plays it can."""
    distance = np.maximum(np.abs(displacement), 1e-9)
    shape = _wished_shape(settings, displacement, distance, generator)
    if settings.least_acceleration is None or settings.least_jerk is None:
        return shape
    acceleration, jerk = (
        float(np.min(least / distance))
        for least in (settings.least_acceleration, settings.least_jerk)
    )
    if shape.peak_acceleration >= acceleration and shape.peak_jerk >= jerk:
        return shape
    return quickest_shape(
        shape.peak_velocity,
        max(shape.peak_acceleration, acceleration),
        max(shape.peak_jerk, jerk),
    )


def _wished_shape(
    settings: PulseSettings,
    displacement: Array,
    distance: Array,
    generator: np.random.Generator,
) -> PulseShape:
    """Choose the time course of one move within each joint's share of speed and acceleration."""
    acceleration = generator.uniform(*settings.acceleration_fraction)
    speed = generator.uniform(*settings.speed_fraction)
    low, high = settings.ramp_s
    ramp_s = float(np.exp(generator.uniform(np.log(low), np.log(high)))) if low > 0.0 else 0.0
    top_acceleration = float(np.min(acceleration * settings.peak_acceleration / distance))
    travel_m = max(settings.point_travel_m(displacement), 1e-12)
    top_velocity = speed * min(
        float(np.min(settings.peak_velocity / distance)), settings.point_speed_m_s / travel_m
    )
    # Without a cruise: 1 = v Ta and v = a (Ta - tr).
    acceleration_s = 0.5 * (ramp_s + np.sqrt(ramp_s**2 + 4.0 / top_acceleration))
    acceleration_s = max(acceleration_s, 2.0 * ramp_s)
    if acceleration_s * top_velocity >= 1.0:
        return PulseShape(2.0 * acceleration_s, acceleration_s, ramp_s)
    acceleration_s = max(ramp_s + top_velocity / top_acceleration, 2.0 * ramp_s)
    duration_s = acceleration_s + 1.0 / top_velocity
    if acceleration_s > 0.5 * duration_s:
        acceleration_s = 0.5 * duration_s
    return PulseShape(duration_s, acceleration_s, min(ramp_s, 0.5 * acceleration_s))
