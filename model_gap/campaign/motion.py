"""The known motion of the joints on the sensors' time grid, and how well it is known."""

from dataclasses import dataclass
import itertools

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign.campaign import MotionNoise
from model_gap.campaign.resample import at_times
from model_gap.campaign.series import RawRecording, Series
from model_gap.campaign.thresholds import CAMPAIGN

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RecordedMotion:
    """Motor-side motion of one recording.

    Parameters
    ----------
    pose : (n_joints,) array [rad]
        Mean of the positions.
    shift, velocity, acceleration : (n_samples, n_joints) array [rad], [rad/s], [rad/s²]
        On the grid; the shift is the position less the pose.
    noise : MotionNoise
        Of what it was made from.
    source : str
        ``joint velocities`` or ``joint positions``.
    highest_hz : float [Hz]
        Up to where it is known.
    note : str
        Why recorded velocities were not used; else empty.
    """

    pose: Array
    shift: Array
    velocity: Array
    acceleration: Array
    noise: MotionNoise
    source: str
    highest_hz: float
    note: str = ''


def motion_on_grid(
    raw: RawRecording, position: Series, order: list[int], grid: Array, rate_hz: float
) -> RecordedMotion:
    """Differentiate recorded joint states and bring them onto the sensors' grid.

    Velocities are used when they were recorded and tell the same as the positions, at the same
    time: a difference of angles is half a period late and knows nothing more.

    Parameters
    ----------
    raw : RawRecording
        Its velocities, if any.
    position : Series
        Its positions.
    order : list of int
        Columns of the series in the order of the model's joints.
    grid : (n_samples,) array [s]
        Times wanted, within the series.
    rate_hz : float [Hz]
        Of the grid.
    """
    values = position.values[:, order]
    pose = values.mean(axis=0)
    highest = min(
        CAMPAIGN.motion_up_to_hz,
        CAMPAIGN.usable_share * position.rate_hz,
        CAMPAIGN.usable_share * rate_hz,
    )
    times = grid - position.start_s

    def derivative(degree: int) -> Array:
        return at_times(values - pose, position.rate_hz, times, degree, highest)

    shift, velocity = derivative(0), derivative(1)
    told = raw.velocity
    if told is not None and told.start_s <= grid[0] and told.end_s >= grid[-1]:
        recorded = told.values[:, order]
        at_grid = at_times(recorded, told.rate_hz, grid - told.start_s, 0, highest)
        why = disagreement(at_grid, velocity, rate_hz)
        if not why:
            rise = at_times(recorded, told.rate_hz, grid - told.start_s, 1, highest)
            noise = MotionNoise(white_density(recorded, told.rate_hz), 1)
            return RecordedMotion(pose, shift, at_grid, rise, noise, 'joint velocities', highest)
    else:
        why = ''
    noise = MotionNoise(white_density(values, position.rate_hz), 2)
    return RecordedMotion(
        pose, shift, velocity, derivative(2), noise, 'joint positions', highest, why
    )


def disagreement(told: Array, derived: Array, rate_hz: float) -> str:
    """Return why recorded velocities cannot be used; empty when they can.

    Parameters
    ----------
    told, derived : (n_samples, n_joints) array [rad/s]
        Recorded, and from the positions, on one grid.
    rate_hz : float [Hz]
        Of the grid.
    """
    moving = derived.std(axis=0) > 1e-6
    if not moving.any():
        return 'no joint moves'
    told, derived = told[:, moving], derived[:, moving]
    pairs = zip(told.T, derived.T, strict=True)
    agreement = min(float(np.corrcoef(one, two)[0, 1]) for one, two in pairs)
    scale = told.std(axis=0) / derived.std(axis=0)
    if agreement < CAMPAIGN.least_agreement or np.any(np.abs(scale - 1.0) > CAMPAIGN.scale_error):
        return 'recorded joint velocities contradict the positions and were not used'
    late = lag_s(told, derived, rate_hz)
    if abs(late) > CAMPAIGN.most_lag_s:
        return (
            f'recorded joint velocities come {1e3 * late:+.2f} ms after the positions and were'
            ' not used'
        )
    return ''


def lag_s(late: Array, early: Array, rate_hz: float) -> float:
    """Return by how much one motion follows another, from the slope of their cross spectrum.

    Parameters
    ----------
    late, early : (n_samples, n_columns) array
        The same motion twice.
    rate_hz : float [Hz]
        Of the samples.

    References
    ----------
    Least squares on the phase -ωτ, weighted by the cross power; Bendat and Piersol (2010), Random
    Data, section 6.4.
    """
    cross = np.sum(np.fft.rfft(late, axis=0) * np.conj(np.fft.rfft(early, axis=0)), axis=1)
    omega = 2.0 * np.pi * np.fft.rfftfreq(len(late), 1.0 / rate_hz)
    power = np.abs(cross)
    return float(-np.sum(omega * power * np.angle(cross)) / np.sum(omega**2 * power))


def white_density(values: Array, rate_hz: float) -> Array:
    """Return the two-sided density of what is white in a recorded quantity, (n_columns,).

    Read above the motion, near half the rate, where the steps of an encoder are all that is left.

    Parameters
    ----------
    values : (n_samples, n_columns) array
        At rest at both ends, or nearly so.
    rate_hz : float [Hz]
        Of the samples.
    """
    window = np.hanning(len(values))[:, None]
    power = np.abs(np.fft.rfft((values - values.mean(axis=0)) * window, axis=0)) ** 2
    power /= rate_hz * float(np.sum(window**2))
    count = len(power) - 1
    edges = np.linspace(
        CAMPAIGN.noise_from * count, CAMPAIGN.noise_to * count, CAMPAIGN.noise_parts + 1
    ).astype(int)
    # The median of an exponential variable is ln 2 times its mean: robust against lines.
    floors = [
        np.median(power[low : max(high, low + 1)], axis=0) / np.log(2.0)
        for low, high in itertools.pairwise(edges)
    ]
    return np.asarray(np.median(floors, axis=0))
