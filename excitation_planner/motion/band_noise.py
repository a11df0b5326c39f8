"""Band-limited noise on the joint speed, for a controller that follows speed references.

The wanted quantity is a flat acceleration spectrum in the band, for inertia turns acceleration
into force.  Every spectral line of the record inside the band gets the wanted amplitude and a
random phase, so the band is filled without the random holes of Gaussian noise, and each joint is
independent of the others.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class BandNoiseSettings:
    """How band-limited noise is drawn.

    Parameters
    ----------
    acceleration_rms : (n_joints,) array [rad/s²]
        Of each joint in the steady part; 0 keeps a joint still.
    band_hz : (2,) tuple [Hz]
        Lowest and highest excited frequency.
    ramp_s : float [s]
        Smooth fade at each end.
    shape_frequency_hz, shape_gain : (n_knots,) tuple [Hz], [-]
        Relative amplitude over frequency, interpolated on a logarithmic axis; empty is flat.
    """

    acceleration_rms: Array
    band_hz: tuple[float, float] = (5.0, 60.0)
    ramp_s: float = 1.0
    shape_frequency_hz: tuple[float, ...] = ()
    shape_gain: tuple[float, ...] = field(default=())

    def amplitude(self, frequency_hz: Array) -> Array:
        """Return the relative acceleration amplitude at each frequency, zero outside the band."""
        inside = (frequency_hz >= self.band_hz[0]) & (frequency_hz <= self.band_hz[1])
        if not self.shape_gain:
            return inside.astype(float)
        safe = np.where(inside, frequency_hz, self.band_hz[0])
        gain = np.interp(np.log(safe), np.log(self.shape_frequency_hz), self.shape_gain)
        return np.where(inside, gain, 0.0)


def band_noise_velocity(
    settings: BandNoiseSettings,
    duration_s: float,
    sample_period_s: float,
    generator: np.random.Generator,
) -> Array:
    """Draw the velocity of every joint.

    The position noise is faded in and out and then differentiated, so the motion starts and ends
    at rest at the start pose without any correction.

    Parameters
    ----------
    settings : BandNoiseSettings
        How to draw.
    duration_s, sample_period_s : float [s]
        Length and grid of the record.
    generator : numpy.random.Generator
        Source of all phases; each joint gets its own stream, so switching one joint off leaves
        the others as they were.

    Returns
    -------
    (n_samples, n_joints) array [rad/s]
        Zero in the first and last row.
    """
    n_samples = round(duration_s / sample_period_s) + 1
    fade, fade_rate = _fade(n_samples, sample_period_s, settings.ramp_s)
    streams = generator.spawn(len(settings.acceleration_rms))
    velocity = np.zeros((n_samples, len(streams)))
    for joint, own in enumerate(streams):
        if settings.acceleration_rms[joint] > 0.0:
            noise = _noise(settings, n_samples, sample_period_s, own)
            rate = fade_rate * noise.position + fade * noise.velocity
            velocity[:, joint] = settings.acceleration_rms[joint] * rate
    # What quadrature leaves of the closed path (about 1e-12 rad) goes back where the fade is open.
    return velocity - np.outer(fade, np.sum(velocity, axis=0)) / np.sum(fade)


@dataclass(frozen=True, slots=True)
class _Noise:
    position: Array
    velocity: Array


def _noise(
    settings: BandNoiseSettings,
    n_samples: int,
    sample_period_s: float,
    generator: np.random.Generator,
) -> _Noise:
    """Return periodic position and velocity of unit acceleration rms."""
    frequency_hz = np.asarray(np.fft.rfftfreq(n_samples, sample_period_s))
    phase = generator.uniform(0.0, 2.0 * np.pi, len(frequency_hz))
    amplitude = settings.amplitude(frequency_hz)
    # Mean square of a sum of cosines of amplitude a is half the sum of their squares.
    amplitude /= np.sqrt(0.5 * np.sum(amplitude**2))
    lines = 0.5 * n_samples * amplitude * np.exp(1j * phase)
    circular = 2.0 * np.pi * np.where(amplitude > 0.0, frequency_hz, 1.0)
    return _Noise(
        position=np.fft.irfft(-lines / circular**2, n_samples),
        velocity=np.fft.irfft(lines / (1j * circular), n_samples),
    )


def _fade(n_samples: int, sample_period_s: float, ramp_s: float) -> tuple[Array, Array]:
    """Return a fade and its rate: a septic step up, a plateau, the same step down."""
    time_s = np.arange(n_samples) * sample_period_s
    left = np.clip(time_s / ramp_s, 0.0, 1.0)
    right = np.clip((time_s[-1] - time_s) / ramp_s, 0.0, 1.0)
    rate = (_step_rate(left) * _step(right) - _step(left) * _step_rate(right)) / ramp_s
    return _step(left) * _step(right), rate


def _step(x: Array) -> Array:
    """Rise from 0 to 1 with three derivatives zero at both ends."""
    return np.asarray(x**4 * (35.0 - 84.0 * x + 70.0 * x**2 - 20.0 * x**3))


def _step_rate(x: Array) -> Array:
    return np.asarray(140.0 * x**3 * (1.0 - x) ** 3)
