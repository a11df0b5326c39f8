"""Taps on the arm at rest: pulses, the arm's response step by step, the converter."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import convolve, firwin

from modal_core.channel import Channel
from modal_core.samples import Samples
from structural_model import FlexibleJointModel
from structural_model.equations import simulate, StateSpace

Real = NDArray[np.float64]
FINER = 4
"""Steps of the simulation per sample of the converter."""
STRAIGHT = np.array([1.0, 10.0, 1.0]) / 12.0
"""What lies between steps: a force of straight lines lacks (πf/rate)²/3 of its samples' spectrum,
2 % at 160 Hz; to 0.1 % up to a tenth of the simulation's rate."""
PASS_BAND = 0.42
"""Of the converter's filter, as a share of its rate."""
FILTER_SAMPLES = 20
"""Half-length of that filter."""


@dataclass(frozen=True, slots=True)
class HammerTaps:
    """What the person does, and how it is recorded.

    Parameters
    ----------
    n_taps : int
    pause_s : float [s]
        Between taps, within a tenth.
    peak_n : float [N]
        Of a usual tap; taps differ by a third.
    width_s : float [s]
        Of the half-sine pulse; a soft tip of 5 to 10 ms excites a robot's modes.
    double : tuple of int
        Taps after which the hammer bounces, 50 ms later, with a third of the force.
    sample_rate_hz : float [Hz]
    noise_m_s2, force_noise_n : float
        Standard deviations of the sensors' noise.
    range_n, range_m_s2 : float
        Where the converter clips.
    """

    n_taps: int = 5
    pause_s: float = 4.0
    peak_n: float = 150.0
    width_s: float = 0.006
    double: tuple[int, ...] = ()
    sample_rate_hz: float = 512.0
    noise_m_s2: float = 0.005
    force_noise_n: float = 0.05
    range_n: float = float('inf')
    range_m_s2: float = float('inf')


@dataclass(frozen=True, slots=True)
class HammerRecord:
    """Force and responses of taps on one point.

    Parameters
    ----------
    force_n : (n_samples,) array [N]
    responses : Samples
        Accelerations.
    hit : str
        Channel along which the hammer struck.
    """

    force_n: Real
    responses: Samples
    hit: str


def tap(
    model: FlexibleJointModel,
    pose: Real,
    channels: Sequence[Channel],
    hit: Channel,
    how: HammerTaps,
    rng: np.random.Generator,
) -> HammerRecord:
    """Tap a point of the arm along a channel.

    Parameters
    ----------
    model : FlexibleJointModel
        Brakes hold the motors.
    pose : (n_joints,) array [rad]
        Serial joint angles.
    channels : sequence of Channel
        Accelerometers.
    hit : Channel
        Where, and in which direction.
    how : HammerTaps
        What the person does.
    rng : Generator
        Of times, sizes and noise.
    """
    rate_hz = how.sample_rate_hz
    force = _force(how, rng)
    system = _system(model, pose, channels, hit)
    motion = simulate(system, force[:, None], FINER * rate_hz).output
    filter_ = firwin(2 * FILTER_SAMPLES * FINER + 1, PASS_BAND * rate_hz, fs=FINER * rate_hz)
    between = convolve(force, STRAIGHT, 'same')
    both = convolve(np.column_stack([between, motion]), filter_[:, None], 'same')[::FINER]
    both[:, 0] += how.force_noise_n * rng.standard_normal(len(both))
    both[:, 1:] += how.noise_m_s2 * rng.standard_normal(both[:, 1:].shape)
    clipped = np.clip(both[:, 1:], -how.range_m_s2, how.range_m_s2)
    samples = Samples(clipped, rate_hz, tuple(channels))
    return HammerRecord(np.minimum(both[:, 0], how.range_n), samples, hit.name)


def _force(how: HammerTaps, rng: np.random.Generator) -> Real:
    """Return half-sine pulses at the rate of the simulation."""
    rate_hz = FINER * how.sample_rate_hz
    force = np.zeros(round((how.n_taps + 0.25) * how.pause_s * rate_hz))
    for number in range(how.n_taps):
        begin_s = (number + 0.1 + 0.1 * rng.uniform()) * how.pause_s
        peak_n = how.peak_n * rng.uniform(0.67, 1.33)
        _add_pulse(force, begin_s, peak_n, how.width_s * rng.uniform(0.9, 1.1), rate_hz)
        if number in how.double:
            _add_pulse(force, begin_s + 0.05, peak_n / 3.0, how.width_s, rate_hz)
    return force


def _add_pulse(force: Real, begin_s: float, peak_n: float, width_s: float, rate_hz: float) -> None:
    first = round(begin_s * rate_hz)
    time_s = np.arange(round(width_s * rate_hz) + 1) / rate_hz
    force[first : first + len(time_s)] += peak_n * np.sin(np.pi * time_s / width_s)


def _system(
    model: FlexibleJointModel, pose: Real, channels: Sequence[Channel], hit: Channel
) -> StateSpace:
    """Return the arm from a force to accelerations."""
    matrices = model.matrices(pose)
    n_dof = len(matrices.M)
    inverse = np.linalg.inv(matrices.M)
    into = model.sensor_jacobian(pose, (hit,)).T
    out = model.sensor_jacobian(pose, channels)
    solved = -inverse @ np.hstack([matrices.K, matrices.C])
    steady = np.hstack([np.zeros((n_dof, n_dof)), np.eye(n_dof)])
    return StateSpace(
        A=np.vstack([steady, solved]),
        B=np.vstack([np.zeros_like(into), inverse @ into]),
        C=out @ solved,
        D=out @ inverse @ into,
        input_names=(f'force at {hit.name}',),
        output_names=tuple(channel.name for channel in channels),
    )
