"""Whole campaigns: an arm within its tolerances, poses, motion, noise, and what is hidden."""

from dataclasses import dataclass
import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation

from benchmarks.gap.multibody.compiled import compiled, Sensor
from benchmarks.gap.multibody.description import read
from benchmarks.gap.multibody.faults import spoil
from benchmarks.gap.multibody.hidden import law_of, put
from benchmarks.gap.multibody.simulate import Motion, Run, simulate, STEP_S
from model_gap.campaign import GapRecord

SENSORS = (
    ('frame', 'link_1', (0.20, 0.42, 0.05)),
    ('lower_arm', 'link_2', (-0.10, -0.15, 0.68)),
    ('elbow', 'link_3', (0.30, -0.15, 0.28)),
    ('spindle', 'flange', (0.20, 0.0, 0.08)),
)
SENSOR_NAMES = tuple(name for name, _, _ in SENSORS)
CENTRE, SPREAD = (0, 0.2, 0.1, 0.3, -0.6, 0.2), (1.0, 0.5, 0.5, 1.2, 0.7, 1.5)
BAND_HZ, LOWEST_HZ, REST_S = (2.5, 50.0), 1.8, 0.4
LEVELS = (0.35, 1.0)
RATE_HZ = 500.0
# Of a record in which nothing moves: enough for the splines of sensors' faults.
STILL_ROWS = 8
# Half of the shortest step.
FINEST = 6
GRID_S = 0.5 * STEP_S / FINEST


@dataclass(frozen=True)
class Conditions:
    """How a campaign is recorded, and how ordinary its arm is.

    Parameters
    ----------
    n_fit, n_held : int
        Poses.
    duration_s : float [s]
        Of each recording.
    noise : float
        Of the accelerometers, of each channel's own size.
    stiffness, damping, mass, inertia, gain : float
        Relative deviations of the arm and its sensors from the model, one standard deviation.
    com_m, place_m : float [m]
        The same of centres of mass and of sensors' places.
    mount_deg : float [deg]
        Of sensors' mounts, about each axis.
    """

    n_fit: int = 3
    n_held: int = 2
    duration_s: float = 16.0
    noise: float = 0.05
    stiffness: float = 0.015
    damping: float = 0.08
    mass: float = 0.01
    inertia: float = 0.02
    gain: float = 0.007
    com_m: float = 0.003
    place_m: float = 0.003
    mount_deg: float = 0.7


def make_records(folder, cases, seed, conditions=None):
    """Return the records of a campaign with these cases hidden in it.

    Parameters
    ----------
    folder : path
        Of the robot.
    cases : sequence of dict
        As ``hidden.draw`` returns them; none: an ordinary arm.
    seed : int
        Of everything drawn.
    conditions : Conditions or None
        How it is recorded.
    """
    how = conditions or Conditions()
    rng = np.random.default_rng(seed)
    arm, gains = _arm(folder, cases, how, rng)
    records = []
    for number in range(how.n_fit + how.n_held):
        pose = _pose(rng)
        for level, size in enumerate(LEVELS):
            motion = motion_of(how.duration_s, size, rng)
            readings = _spoilt(cases, _readings(arm, cases, pose, motion, how, rng), rng) * gains
            own = (readings - readings.mean(axis=0)).std(axis=0)
            readings = readings + how.noise * own * rng.standard_normal(readings.shape)
            name, held = f'p{number}_l{level}', number >= how.n_fit
            records.append(_record(name, pose, level, readings, motion, held))
    return tuple(records)


def still_records(folder, cases, seed, conditions=None):
    """Return records of an arm that stands still in its poses: what the means can tell.

    Parameters are those of :func:`make_records`.
    """
    how = conditions or Conditions()
    rng = np.random.default_rng(seed)
    arm, gains = _arm(folder, cases, how, rng)
    still, records = np.zeros((STILL_ROWS, 6)), []
    for number in range(how.n_fit + how.n_held):
        pose = _pose(rng)
        real, laws = _standing(arm, cases, pose, how, rng)
        run = Run(arm, laws, real, Motion(still, still), STEP_S)
        read = np.tile(run.read_at_rest(run.at_rest()), (STILL_ROWS, 1))
        readings = _spoilt(cases, read, rng) * gains
        records.append(GapRecord(f'p{number}', pose, '1', RATE_HZ, readings, still, still, still))
    return tuple(records)


def _arm(folder, cases, how, rng):
    """Return one arm of its make, what is hidden built in, and the gains of its channels."""
    description = _ordinary(read(folder), how, rng)
    sensors, gains = sensors_of(cases, how, rng)
    for case in cases:
        put(case, description)
    return compiled(description, sensors), gains


def _pose(rng):
    return np.array(CENTRE) + np.array(SPREAD) * rng.uniform(-1.0, 1.0, 6)


def _spoilt(cases, readings, rng):
    for case in cases:
        readings = spoil(case, readings, RATE_HZ, _columns(case), rng)
    return readings


def _standing(arm, cases, pose, how, rng):
    """Return the pose the arm really has, and the laws of its gears."""
    real = np.array(pose, float)
    for case in cases:
        if case['type'] == 'encoder_offset':
            real[int(case['place'][-1]) - 1] += case['offset']
    laws = [law_of(case, arm, real, how.duration_s, rng) for case in cases]
    return real, [law for law in laws if law is not None]


def _ordinary(arm, how, rng):
    """Return the arm as one of many of its make."""
    for axis in arm.axes:
        for spring in (axis.drive, *axis.tilts):
            _vary(spring, how, rng)
    for spring in arm.base.values():
        spring.k *= 1.0 + min(how.stiffness, 0.02) * rng.standard_normal()
    for link in arm.links:
        for lump in link.lumps:
            share = 1.0 + how.mass * rng.standard_normal()
            lump.mass *= share
            lump.inertia = lump.inertia * share * (1.0 + how.inertia * rng.standard_normal())
            lump.com = lump.com + how.com_m * rng.standard_normal(3)
    return arm


def _vary(spring, how, rng):
    """Small deviations are Gaussian; of a model known roughly every size is as likely."""
    if how.stiffness > 0.1:
        share = 1.0 + rng.uniform(-how.stiffness, how.stiffness)
    else:
        share = 1.0 + how.stiffness * rng.standard_normal()
    spring.k *= share
    spring.c *= share * math.exp(how.damping * rng.standard_normal())


def sensors_of(cases, how, rng):
    """Return sensors as they really sit, and the gains of their channels."""
    found = []
    for name, link, at in SENSORS:
        turned = Rotation.from_rotvec(math.radians(how.mount_deg) * rng.standard_normal(3))
        place = np.array(at) + how.place_m * rng.standard_normal(3)
        for case in cases:
            if case['type'] == 'sensor_position' and case['place'] == name:
                place = place + case['shift']
        found.append(Sensor(name, link, place, turned.as_matrix()))
    return found, 1.0 + how.gain * rng.standard_normal(3 * len(SENSORS))


def motion_of(duration_s, size, rng):
    """Return random motion of all motors, a sixth of a step apart, from rest to rest.

    Filtered white noise, made smooth at both ends, drawn by a spline whose derivatives are exact.
    """
    rate = 1000.0
    count = round(duration_s * rate) + 1
    shaking = butter(4, BAND_HZ, 'bandpass', fs=rate, output='sos')
    wanted = sosfiltfilt(shaking, rng.standard_normal((count + 2000, 6)), axis=0)[1000:-1000]
    spectrum = np.fft.rfft(wanted, axis=0)
    omega = 2.0 * np.pi * np.fft.rfftfreq(count, 1.0 / rate)
    # Twice integrated, what leaks below the band would be degrees of slow wandering.
    omega[omega < 2.0 * np.pi * LOWEST_HZ] = np.inf
    shift = np.fft.irfft(-spectrum / omega[:, None] ** 2, count, axis=0)
    edge = np.minimum(np.arange(count), np.arange(count)[::-1]) / rate
    window = np.sin(0.5 * np.pi * np.clip((edge - 0.01) / REST_S, 0.0, 1.0)) ** 4
    spline = CubicSpline(np.arange(count) / rate, shift * window[:, None], axis=0)
    times = np.arange(round(duration_s / GRID_S) + 1) * GRID_S
    scale = size / spline(times, 2).std(axis=0)
    return Motion(spline(times) * scale, spline(times, 1) * scale)


def _readings(arm, cases, pose, motion, how, rng):
    """Return what ideal accelerometers read, antialiased."""
    played = motion
    for case in cases:
        if case['type'] == 'command_delay':
            played = _later(played, case['delay'])
    real, found = _standing(arm, cases, pose, how, rng)
    finer = max([law.finer for law in found], default=1)
    rows = slice(None, None, FINEST // finer)
    seen = Motion(played.position[rows], played.velocity[rows])
    fine = simulate(arm, found, real, seen, finer)
    keep = round(1.0 / (STEP_S * RATE_HZ))
    low = butter(8, 200.0, fs=RATE_HZ * keep, output='sos')
    rest = fine[0]
    return (rest + sosfiltfilt(low, fine - rest, axis=0))[::keep]


def _later(motion, delay_s):
    times = np.arange(len(motion.position)) * GRID_S
    wanted = np.clip(times - delay_s, 0.0, None)
    return Motion(
        CubicSpline(times, motion.position, axis=0)(wanted),
        CubicSpline(times, motion.velocity, axis=0)(wanted),
    )


def _columns(case):
    if case['place'] not in SENSOR_NAMES:
        return list(range(3 * len(SENSORS)))
    first = 3 * SENSOR_NAMES.index(case['place'])
    return [first, first + 1, first + 2]


def _record(name, pose, level, readings, motion, held):
    """Return a record as the workflow reads it: the motion as the joint states tell it."""
    keep = round(1.0 / (GRID_S * RATE_HZ))
    velocity = motion.velocity
    acceleration = np.gradient(velocity, GRID_S, axis=0)
    count = min(len(readings), (len(velocity) + keep - 1) // keep)
    rows = slice(0, count * keep, keep)
    middle = motion.position.mean(axis=0)
    return GapRecord(
        name,
        np.array(pose) + middle,
        str(level),
        RATE_HZ,
        readings[:count],
        acceleration[rows][:count],
        velocity[rows][:count],
        motion.position[rows][:count] - middle,
        heldout=held,
    )
