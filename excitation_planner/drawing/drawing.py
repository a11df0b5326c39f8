"""The motion a request asks for; its randomness comes from the seed alone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.drawing.gear_rate import twist_rate_rms
from excitation_planner.motion import (
    band_noise_velocity,
    BandNoiseSettings,
    expected_share,
    LEAST_ACCELERATION,
    LEAST_JERK,
    LEAST_OF_SHARE,
    predicted_spectrum,
    Pulse,
    pulse_velocity,
    PulseSettings,
    random_pulses,
    sweep_speed,
    sweep_velocity,
    SweepSettings,
    Trajectory,
    turn_rise,
    wanted_half_range,
)
from excitation_planner.pose_range import actual_change, allowed_range, AllowedRange, is_allowed
from excitation_planner.setting import Setting
from excitation_planner.signals import RANDOM_PULSES, SLIDING_NOISE
from modal_core.errors import PlanError
from modal_core.words.named import named
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
# Of the point speed that noise and sweeps may expect to use, and the noise's peak over its rms.
SPEED_ROOM, NOISE_PEAK = 0.9, 4.0
# Of the acceleration limit that the noise's largest peak and a turn of the sweep may use together.
ACCELERATION_ROOM, FINER = 0.97, 4
# Weaker noise would leave modes in the noise of sensors.
MOST_LOWERED_DB = 30
# Of the allowed range, so that a search that begins elsewhere does not end a little beyond it.
RANGE_ROOM = 0.93


@dataclass(frozen=True, slots=True)
class Drawn:
    """A motion.

    Parameters
    ----------
    trajectory : Trajectory
        Serial joints.
    peak_acceleration : (n_joints,) array [rad/s²]
        Of pulses before they were sampled, serial joints; else zeros.
    notices : tuple of str
        Where it is less than was asked.
    """

    trajectory: Trajectory
    peak_acceleration: Array
    notices: tuple[str, ...] = ()


def draw_motion(setting: Setting) -> Drawn:
    """Draw the motion a request asks for.

    Raises
    ------
    PlanError
        No pulse fits, or the allowed range is too small for the signal.
    """
    request = setting.request
    peaks: Array = np.zeros(len(setting.weights))
    notices: tuple[str, ...] = ()
    if request.signal == RANDOM_PULSES:
        velocity, peaks = _draw_pulses(setting)
    else:
        velocity = _draw_noise(setting)
        if request.signal == SLIDING_NOISE:
            velocity, notices = _on_sweeps(setting, velocity)
    # Signals are drawn for the controller axes: those are what the drives move independently.
    serial = setting.model.to_serial(velocity)
    trajectory = Trajectory.from_velocity(setting.start, serial, request.sample_period_s)
    return Drawn(trajectory, peaks, notices)


def _draw_noise(setting: Setting) -> Array:
    request = setting.request
    noise = BandNoiseSettings(
        acceleration_rms=request.acceleration_rms * setting.weights,
        band_hz=(request.band_low_hz, request.band_high_hz),
        ramp_s=request.fade_s,
        shape_frequency_hz=request.shape_frequency_hz,
        shape_gain=request.shape_gain,
    )
    generator = np.random.default_rng(request.seed)
    return band_noise_velocity(noise, request.duration_s, request.sample_period_s, generator)


def _draw_pulses(setting: Setting) -> tuple[Array, Array]:
    request = setting.request
    duration_s, period_s = request.duration_s, request.sample_period_s
    generator = np.random.default_rng(request.seed)
    pulses = random_pulses(pulse_settings(setting), duration_s, period_s, generator)
    if not pulses:
        raise PlanError(
            'no pulse and its way back fit',
            where='duration_s',
            found=f'{duration_s:g} s',
            advice='lengthen the plan, shorten the pauses or narrow the range',
        )
    velocity = pulse_velocity(pulses, round(duration_s / period_s) + 1, period_s)
    return velocity, np.max([_peak_acceleration(pulse, setting.model) for pulse in pulses], axis=0)


def _on_sweeps(setting: Setting, noise: Array) -> tuple[Array, tuple[str, ...]]:
    """Put noise on slow sweeps inside the allowed range.

    The noise is as strong as asked for, or as what sweeps inside the allowed range and speed can
    still keep from turning the joints back.
    """
    request = setting.request
    sweeps, lowered_db = _sweeps(setting, noise)
    moving = sweeps.speed > 0.0
    share = expected_share(sweeps.half_range[moving], sweeps.speed[moving], request.presliding_rad)
    least = LEAST_OF_SHARE * request.sliding_share
    if np.min(share, initial=1.0) < least:
        raise PlanError(
            'joints would hardly slide in the allowed range',
            where=f'sweep of {np.rad2deg(np.max(sweeps.half_range)):.3f} deg',
            found=f'{100 * np.min(share):.0f} % of the time',
            expected=f'>= {100 * least:g} %',
            advice='raise frequency_tolerance or half_range, or plan band_limited_noise',
        )
    # The player's amplitude grows while the noise does; what goes far begins after that.
    later = round(request.fade_s / request.sample_period_s)
    left_s = request.duration_s - later * request.sample_period_s
    generator = np.random.default_rng([request.seed, 3])
    drawn = sweep_velocity(sweeps, left_s, request.sample_period_s, generator)
    velocity = noise * 10.0 ** (-lowered_db / 20.0)
    velocity[len(noise) - len(drawn) :] += drawn
    told = f'noise {lowered_db} dB below what was asked, for joints to slide in the allowed range'
    return velocity, (told,) if lowered_db else ()


def _sweeps(setting: Setting, noise: Array) -> tuple[SweepSettings, int]:
    """Return sweeps for noise as strong as they allow, and by how much it is lowered [dB]."""
    request = setting.request
    rate = _gear_rate(setting, noise)
    lever_m = np.array([_travel_m(setting, unit) for unit in np.eye(len(rate))])
    noise_rms = np.sqrt(np.mean(noise**2, axis=0))
    noise_peak = _peak_rise(noise, request.sample_period_s)
    most = ACCELERATION_ROOM * setting.model.limits.acceleration

    def at(lowered_db: int) -> SweepSettings:
        speed = sweep_speed(rate * 10.0 ** (-lowered_db / 20.0))
        reach = wanted_half_range(speed, request.presliding_rad, request.sliding_share)
        return SweepSettings(reach, speed)

    def kept(lowered_db: int) -> bool:
        sweeps = at(lowered_db)
        shaken = lever_m * noise_rms * 10.0 ** (-lowered_db / 20.0)
        fastest_m_s = lever_m @ sweeps.speed + NOISE_PEAK * np.sqrt(np.sum(shaken**2))
        if fastest_m_s > SPEED_ROOM * request.point_speed_m_s:
            return False
        if np.any(noise_peak * 10.0 ** (-lowered_db / 20.0) + turn_rise(sweeps.speed) > most):
            return False
        return _is_in_range(setting, sweeps.half_range)

    inside, outside = MOST_LOWERED_DB, -1
    while inside - outside > 1:
        middle = (inside + outside) // 2
        inside, outside = (middle, outside) if kept(middle) else (inside, middle)
    sweeps = at(inside)
    if inside == MOST_LOWERED_DB and not kept(inside):
        sweeps = SweepSettings(_narrowed(setting, sweeps.half_range), sweeps.speed)
    return sweeps, inside


def _peak_rise(velocity: Array, sample_period_s: float) -> Array:
    """Return the largest acceleration of each axis, also between the samples [rad/s²]."""
    motion = Trajectory.from_velocity(np.zeros(velocity.shape[1]), velocity, sample_period_s)
    return np.asarray(np.max(np.abs(motion.finer(FINER).acceleration), axis=0))


def _gear_rate(setting: Setting, noise: Array) -> Array:
    """Return how fast noise moves the links of each axis, ringing included (rms) [rad/s]."""
    request = setting.request
    rise = np.gradient(noise, request.sample_period_s, axis=0)
    spectrum = predicted_spectrum(rise, request.sample_period_s)
    twist = twist_rate_rms(setting.model, setting.start, spectrum, request.band_high_hz)
    both = np.sqrt(np.mean(noise**2, axis=0) + twist**2)
    return np.where(setting.weights > 0.0, both, 0.0)


def _is_in_range(setting: Setting, half_range: Array) -> bool:
    request, model = setting.request, setting.model
    if 0.0 < request.half_range < np.max(half_range):
        return False
    tolerance = RANGE_ROOM * request.frequency_tolerance if request.enforce_tolerance else np.inf
    change = actual_change(model, setting.start, request.band_high_hz)
    return is_allowed(change, setting.start, half_range, tolerance, model.limits)


def _narrowed(setting: Setting, half_range: Array) -> Array:
    """Return the part of sweeps that the range allows."""
    request, largest = setting.request, float(np.max(half_range))
    if 0.0 < request.half_range < largest:
        half_range, largest = half_range * request.half_range / largest, request.half_range
    if not request.enforce_tolerance or largest == 0.0:
        return half_range
    found = allowed_range(
        actual_change(setting.model, setting.start, request.band_high_hz),
        setting.start,
        half_range / largest,
        RANGE_ROOM * request.frequency_tolerance,
        setting.model.limits,
        np.random.default_rng([request.seed, 1]),
    )
    return np.asarray(np.minimum(half_range, RANGE_ROOM * found.half_range))


def _travel_m(setting: Setting, displacement: Array) -> float:
    """Return how far the fastest point of the arm goes in a move of the controller axes [m]."""
    move = setting.model.to_serial(displacement)
    fastest = setting.model.geometry.fastest_point(setting.start[None], move[None])
    return float(fastest.speed_m_s[0])


def _peak_acceleration(pulse: Pulse, model: FlexibleJointModel) -> Array:
    return np.asarray(np.abs(model.to_serial(pulse.displacement)) * pulse.shape.peak_acceleration)


def pulse_settings(setting: Setting) -> PulseSettings:
    """Return how pulses are drawn: the range is the allowed one unless a smaller one is asked."""
    request, limits = setting.request, setting.model.limits
    _check_acceleration_known(setting)
    half_range = request.half_range * setting.weights
    if request.half_range == 0.0 or request.enforce_tolerance:
        allowed = find_allowed_range(setting)
        if request.half_range == 0.0:
            half_range = allowed.half_range
        elif np.any(half_range > allowed.half_range):
            worst = int(np.argmax(half_range / np.maximum(allowed.half_range, 1e-12)))
            raise PlanError(
                'the range changes a natural frequency by more than the tolerance',
                where=f'half_range of {setting.model.axis_names[worst]}',
                found=f'{np.rad2deg(half_range[worst]):.3f} deg',
                expected=f'<= {np.rad2deg(allowed.half_range[worst]):.3f} deg for'
                f' {100 * request.frequency_tolerance:g} %',
            )
    n_moving = int(np.count_nonzero(setting.weights))

    # Wherever the request allows it, moves are such that a program of the controller makes them.
    playable = (
        request.synchronised
        and request.jerk_limited
        and request.acceleration_high >= LEAST_ACCELERATION
    )
    return PulseSettings(
        half_range=half_range,
        peak_velocity=limits.velocity,
        peak_acceleration=limits.acceleration,
        interval_s=(request.interval_low_s, request.interval_high_s),
        acceleration_fraction=(request.acceleration_low, request.acceleration_high),
        ramp_s=(request.ramp_low_s, request.ramp_high_s),
        speed_fraction=(request.speed_low, request.speed_high),
        point_speed_m_s=request.point_speed_m_s / (1 if request.synchronised else n_moving),
        point_travel_m=lambda displacement: _travel_m(setting, displacement),
        synchronised=request.synchronised,
        least_acceleration=LEAST_ACCELERATION * limits.acceleration if playable else None,
        least_jerk=LEAST_JERK * limits.jerk if playable else None,
    )


def _check_acceleration_known(setting: Setting) -> None:
    """Refuse moves of an axis whose acceleration nobody stated: a move is made of it."""
    unknown = ~np.isfinite(setting.model.limits.acceleration) & (setting.weights > 0.0)
    if unknown.any():
        names = [setting.model.axis_names[axis] for axis in np.flatnonzero(unknown)]
        raise PlanError(
            'moves need the acceleration of every axis that moves',
            where=setting.model.robot_name,
            found=f'none of {named(names)}',
            advice='state acceleration_deg_s2, and jerk_deg_s3, under limits in its model.yaml',
        )


def find_allowed_range(setting: Setting) -> AllowedRange:
    """Return the largest joint range that keeps the frequency tolerance."""
    request = setting.request
    change = actual_change(setting.model, setting.start, request.band_high_hz)
    return allowed_range(
        change,
        setting.start,
        setting.weights / np.max(setting.weights),
        request.frequency_tolerance,
        setting.model.limits,
        np.random.default_rng([request.seed, 1]),
    )
