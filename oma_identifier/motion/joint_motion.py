"""Joint positions, speeds and accelerations out of sampled positions, without their noise.

Two differentiations multiply a position's noise by the square of the frequency.  The positions
are therefore filtered first by the gain that is best in the mean square (Wiener): what the joint
does stands out of the white noise of its encoder up to some frequency, and is kept up to there.

References
----------
Wiener (1949), Extrapolation, Interpolation, and Smoothing of Stationary Time Series, eq. 3.15
(gain signal over signal plus noise).
"""

from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft
from scipy.ndimage import uniform_filter1d

from modal_core.measurements import NANOSECONDS_PER_SECOND
from oma_identifier.motion.thresholds import MOTION
from oma_identifier.time_axis import Lattice, make_lattice, OrderedSamples


@dataclass(frozen=True, slots=True)
class JointMotion:
    """Motion of the joints at equal steps.

    Parameters
    ----------
    origin_ns : float [ns]
        Time of the first row, from the reference time given.
    period_ns : float [ns]
        Step.
    position, velocity, acceleration : (n_samples, n_joints) array [rad], [rad/s], [rad/s²]
        Noise removed.
    """

    origin_ns: float
    period_ns: float
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    acceleration: NDArray[np.float64]

    def delayed(self, lag_s: float) -> 'JointMotion':
        """Return the same motion, later by some time."""
        return replace(self, origin_ns=self.origin_ns + lag_s * NANOSECONDS_PER_SECOND)


def joint_motion(
    stamp_ns: NDArray[np.int64],
    position: NDArray[np.float64],
    reference_ns: int,
    highest_hz: float = math.inf,
) -> JointMotion | None:
    """Differentiate sampled joint positions.

    Parameters
    ----------
    stamp_ns : (n_samples,) int64 array [ns]
        In order; repeats are dropped.
    position : (n_samples, n_joints) array [rad]
        Sampled at roughly equal steps.
    reference_ns : int [ns]
        Time that ``origin_ns`` counts from.
    highest_hz : float [Hz]
        Motion above is left out, fading out.

    Returns
    -------
    JointMotion or None
        None when samples are too few, not finite, or missing for long.
    """
    stamps, first = np.unique(stamp_ns, return_index=True)
    if len(stamps) < MOTION.fewest_samples or not np.isfinite(position).all():
        return None
    period_ns = float(np.median(np.diff(stamps)))
    ordered = OrderedSamples(stamps, position[first])
    lattice = make_lattice(ordered, reference_ns, period_ns, uniform=False)
    if lattice is None or lattice.lost.any():
        return None
    return _differentiated(lattice, highest_hz)


def _differentiated(lattice: Lattice, highest_hz: float) -> JointMotion:
    values, period_s = lattice.values, lattice.period_ns * 1e-9
    n = len(values)
    # Each end goes on along a parabola for a while; the line between the new ends is taken out and
    # the rest continued by point reflection, so that steps in curvature lie beyond the ends.
    longer = _extended(values)
    slope = (longer[-1] - longer[0]) / (len(longer) - 1)
    line = longer[0] + np.arange(len(longer))[:, None] * slope
    rest = longer - line
    odd = np.concatenate([rest, -rest[-2:0:-1]])
    inside = slice(MOTION.beyond_ends, MOTION.beyond_ends + n)
    length = len(odd)
    spectrum = rfft(odd, axis=0)
    power = np.abs(spectrum) ** 2
    spectrum *= _gain(power) * _fade(len(power), 2.0 * highest_hz * period_s)
    turn = 2.0j * math.pi * np.arange(len(spectrum))[:, None] / (length * period_s)
    return JointMotion(
        origin_ns=lattice.origin_ns,
        period_ns=lattice.period_ns,
        position=(irfft(spectrum, length, axis=0)[: len(line)] + line)[inside],
        velocity=irfft(spectrum * turn, length, axis=0)[inside] + slope / period_s,
        acceleration=irfft(spectrum * turn**2, length, axis=0)[inside],
    )


def _extended(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the values continued at both ends along a parabola through a few samples."""
    near, ahead = np.arange(MOTION.end_samples), np.arange(1, MOTION.beyond_ends + 1)
    powers = np.vander(near, 3)
    after = values[-MOTION.end_samples :] - values[-1]
    before = values[MOTION.end_samples - 1 :: -1] - values[0]
    beyond = np.vander(MOTION.end_samples - 1 + ahead, 3)
    late = values[-1] + beyond @ np.linalg.lstsq(powers, after, rcond=None)[0]
    early = values[0] + beyond @ np.linalg.lstsq(powers, before, rcond=None)[0]
    return np.concatenate([early[::-1], values, late])


def _noise(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the power of white noise per joint, from where nothing else is left."""
    # The mean of exponentially distributed powers is their median over ln 2.
    return np.asarray(
        np.median(power[int(MOTION.noise_band * len(power)) :], axis=0) / math.log(2.0)
    )


def _gain(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Wiener gain per frequency and joint."""
    smooth = uniform_filter1d(power, max(5, len(power) // 100) | 1, axis=0)
    share = np.divide(_noise(power), smooth, out=np.ones_like(smooth), where=smooth > 0.0)
    return np.asarray(np.clip(1.0 - MOTION.noise_safety * share, 0.0, 1.0))


def _fade(n: int, highest: float) -> NDArray[np.float64]:
    """Return the gain that ends the band, (n, 1); ``highest`` is a share of it."""
    first = min(highest, MOTION.taper)
    last = min(MOTION.fade * highest, 1.0)
    part = np.clip((np.arange(n) / n - first) / (last - first), 0.0, 1.0)
    return np.asarray(0.5 + 0.5 * np.cos(math.pi * part))[:, None]
