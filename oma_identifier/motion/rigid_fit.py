"""How late the responses are to the joint states, and up to where the arm follows its motors.

Joint states tell the angles of the motors, by another clock than that of the responses.  Well
below the first natural frequency the links follow the motors and sensors read what a rigid arm
would: there the phase of the cross spectrum of predicted and measured readings is frequency times
delay.  Above, the links stand still while the motors shake; taking "rigid motion" out would put it
in.

References
----------
Bendat and Piersol (2010), Random Data, 4th ed., section 5.2 (delay from phase) and table 9.6
(variance of the phase of a cross spectrum).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from oma_identifier.motion.thresholds import MOTION

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

ROUNDS = 5
EVEN = 32
"""Lengths are cut to a multiple of this, which Fourier transforms like."""


@dataclass(frozen=True, slots=True)
class SlowMotion:
    """Fourier lines far below the first mode, where every link follows the motors.

    Parameters
    ----------
    measured, rigid : (n_values, n_channels) array
        Their real and imaginary parts; possibly none.
    """

    measured: Real
    rigid: Real


@dataclass(frozen=True, slots=True)
class RigidFit:
    """How the readings of a rigid arm fit the measured ones.

    Parameters
    ----------
    lag_s, lag_std_s : (n_channels,) array [s]
        How much later than the joint states each channel is, and its standard deviation.
    reach_hz : float [Hz]
        Up to here the arm follows its motors; infinite when nothing says that it stops.
    odd : (n_channels,) bool array
        Channels whose delay differs from that of the others.
    slow : SlowMotion
        What tells whether sensors read what they should.
    """

    lag_s: Real
    lag_std_s: Real
    reach_hz: float
    odd: NDArray[np.bool_]
    slow: SlowMotion

    @property
    def proved_lag_s(self) -> Real:
        """The delay where it is significant; stamps are believed until they are proved wrong."""
        return np.where(np.abs(self.lag_s) > MOTION.significant * self.lag_std_s, self.lag_s, 0.0)

    @property
    def common_lag_s(self) -> float:
        """Delay of most channels."""
        return float(np.median(self.lag_s))

    @property
    def common_lag_std_s(self) -> float:
        """Standard deviation of that delay."""
        return float(np.median(self.lag_std_s))


@dataclass(frozen=True, slots=True)
class _Spectra:
    """Power and cross power per band of lines and channel, (n_bands, n_channels) each.

    ``late`` is the cross power's imaginary part times angular frequency, ``early`` its real part
    times the square of that: what a delay makes of the former it makes of the latter.
    """

    upper_hz: Real
    rigid: Real
    measured: Real
    cross: Complex
    late: Real
    early: Real

    @property
    def ratio(self) -> Real:
        """Power measured over power predicted, all channels together."""
        return np.asarray(self.measured.sum(axis=1) / (self.rigid.sum(axis=1) + 1e-300))

    @property
    def coherence(self) -> Real:
        """Squared coherence, all channels together, whatever their phases."""
        power = self.measured.sum(axis=1) * self.rigid.sum(axis=1)
        return np.asarray(np.abs(self.cross).sum(axis=1) ** 2 / (power + 1e-300))

    @property
    def left(self) -> Real:
        """Share of the measured power that subtraction leaves."""
        left = (self.measured + self.rigid - 2.0 * self.cross.real).sum(axis=1)
        return np.asarray(left / (self.measured.sum(axis=1) + 1e-300))


def rigid_fit(
    measured: Real, rigid: Real, sample_rate_hz: float, sensors: Sequence[str]
) -> RigidFit | None:
    """Compare the readings of a rigid arm with the measured ones.

    Parameters
    ----------
    measured, rigid : (n_samples, n_channels) array
        On one grid, each by its own stamps.
    sample_rate_hz : float [Hz]
        Of the grid.
    sensors : sequence of str
        What the channels of one clock have in common.

    Returns
    -------
    RigidFit or None
        None where nothing moves as a rigid arm would.
    """
    shift, fit = 0, None
    most = round(MOTION.latest_s * sample_rate_hz)
    for _ in range(ROUNDS):
        # A taper stands still where the motion under it is late: better to move the motion first.
        late, early = max(shift, 0), max(-shift, 0)
        length = (len(measured) - abs(shift)) // EVEN * EVEN
        fit = _fit(
            measured[late : late + length],
            rigid[early : early + length],
            sample_rate_hz,
            sensors,
        )
        if fit is None:
            return None
        step = round(fit.common_lag_s * sample_rate_hz)
        if step == 0 or abs(shift + step) > most:
            break
        shift += step
    return None if fit is None else replace(fit, lag_s=fit.lag_s + shift / sample_rate_hz)


def _fit(
    measured: Real, rigid: Real, sample_rate_hz: float, sensors: Sequence[str]
) -> RigidFit | None:
    taper = np.hanning(len(measured))[:, None]
    scale = measured.std(axis=0)
    scale[scale == 0.0] = np.inf
    response = rfft((measured - measured.mean(axis=0)) * taper / scale, axis=0)
    motion = rfft((rigid - rigid.mean(axis=0)) * taper / scale, axis=0)
    line_hz = np.arange(len(response)) * sample_rate_hz / len(measured)
    plain = _pooled(line_hz, response, motion)
    follows, end = _follows(plain)
    if not follows.any():
        return None
    lag_s = _coarse(line_hz, response * motion.conj(), plain, follows)
    response *= np.exp(2j * np.pi * line_hz * lag_s)[:, None]
    pooled = _pooled(line_hz, response, motion)
    useful = np.flatnonzero(follows & (pooled.left < MOTION.useful))
    if len(useful) == 0:
        return None
    rest_s, std_s, odd = _delays(pooled, follows, sensors)
    highest_hz = float(pooled.upper_hz[useful[-1]])
    reach_hz = highest_hz if end < len(follows) else math.inf
    below = slice(MOTION.first_line, int(np.searchsorted(line_hz, MOTION.followed * highest_hz)))
    slow = SlowMotion(*(_parts(part[below] * scale) for part in (response, motion)))
    return RigidFit(lag_s + rest_s, std_s, reach_hz, odd, slow)


def _parts(lines: Complex) -> Real:
    return np.concatenate([lines.real, lines.imag])


def _pooled(line_hz: Real, response: Complex, motion: Complex) -> _Spectra:
    first = np.arange(
        MOTION.first_line, len(line_hz) - MOTION.pooled_lines + 1, MOTION.pooled_lines
    )
    last = first[-1] + MOTION.pooled_lines
    cross, turn = response[:last] * motion[:last].conj(), 2.0 * np.pi * line_hz[:last, None]

    def pool(values: Real) -> Real:
        return np.asarray(np.add.reduceat(values[:last], first, axis=0))

    return _Spectra(
        upper_hz=line_hz[first + MOTION.pooled_lines - 1],
        rigid=pool(np.abs(motion) ** 2),
        measured=pool(np.abs(response) ** 2),
        cross=pool(cross.real) + 1j * pool(cross.imag),
        late=-pool(turn * cross.imag),
        early=pool(turn**2 * cross.real),
    )


def _follows(spectra: _Spectra) -> tuple[NDArray[np.bool_], int]:
    """Return the bands in which the arm follows its motors, and the first where it does not."""
    ratio, moves = spectra.ratio, spectra.coherence > MOTION.coherent
    alike = (ratio > 1.0 / MOTION.power_ratio) & (ratio < MOTION.power_ratio)
    # Where motion is lost in noise nothing can be said; a mode, or links left behind, end it.
    ends = np.flatnonzero((moves & ~alike) | (ratio <= 1.0 / MOTION.power_ratio))
    end = int(ends[0]) if len(ends) else len(moves)
    follows = moves & alike
    follows[end:] = False
    return np.asarray(follows), end


def _coarse(line_hz: Real, cross: Complex, spectra: _Spectra, follows: NDArray[np.bool_]) -> float:
    """Return the delay that brings the phases of all bands together."""
    weight = np.zeros(len(line_hz))
    power = np.sqrt(spectra.measured.sum(axis=1) * spectra.rigid.sum(axis=1))
    for band in np.flatnonzero(follows):
        weight[
            MOTION.first_line + band * MOTION.pooled_lines : MOTION.first_line
            + (band + 1) * MOTION.pooled_lines
        ] = 1.0 / power[band]
    used = weight > 0.0
    together = cross[used].sum(axis=1) * weight[used]
    highest_hz = float(line_hz[used].max())
    step_s = min(0.1, 0.125 / highest_hz)
    delays = np.arange(-MOTION.latest_s, MOTION.latest_s + step_s, step_s)
    turns = np.exp(2j * np.pi * np.outer(delays, line_hz[used]))
    # Of nearly equal ones the smallest: slow motion alone says little.
    agreement = (turns @ together).real
    near = agreement >= agreement.max() - 1e-3 * abs(agreement.max())
    return float(delays[near][np.argmin(np.abs(delays[near]))])


def _delays(
    spectra: _Spectra, follows: NDArray[np.bool_], sensors: Sequence[str]
) -> tuple[Real, Real, NDArray[np.bool_]]:
    """Return delays, standard deviations and which channels differ, by weighted least squares."""
    cross, rigid, measured, late, early = (
        part[follows]
        for part in (spectra.cross, spectra.rigid, spectra.measured, spectra.late, spectra.early)
    )
    coherence = np.clip(np.abs(cross) ** 2 / (rigid * measured + 1e-300), 0.0, 1.0)
    clear = (coherence > MOTION.coherent) & (early > 0.0)
    gain = np.sqrt(measured / (rigid + 1e-300))
    noise = measured * (1.0 - coherence) / MOTION.pooled_lines + 1e-12 * measured
    delay = np.divide(late, early, out=np.zeros_like(late), where=clear)
    variance = np.divide(noise * gain, 2.0 * early, out=np.ones_like(late), where=clear)
    # What the first mode amplifies it also delays, in all channels and bands alike.
    turn = np.sqrt(np.divide(early, np.abs(cross), out=np.ones_like(late), where=clear))
    grown = np.abs(gain - 1.0) * 2.0 * MOTION.assumed_damping / turn
    weight = np.where(clear, 1.0 / (variance + grown**2), 0.0)
    names = np.array(sensors)
    groups = [names == name for name in dict.fromkeys(sensors)]
    own = [_mean(delay[:, mine], weight[:, mine], 0.0 * grown[:, mine]) for mine in groups]
    heard = np.array([math.isfinite(std) for _, std in own])
    middle = np.median([mean for mean, std in own if math.isfinite(std)]) if heard.any() else 0.0
    # Sensors differ by what flexibility does to each, which their own scatter tells.
    scatter = np.array([abs(mean - middle) for mean, std in own if math.isfinite(std)])
    shared = _mean(delay, weight, grown)[1]
    usual = 1.4826 * float(np.median(scatter)) if len(scatter) >= MOTION.few_sensors else shared
    odd = np.zeros(delay.shape[1], dtype=bool)
    for mine, (mean, std) in zip(groups, own, strict=True):
        odd[mine] = abs(mean - middle) > MOTION.apart * math.hypot(std, usual)
    whole, whole_std = _mean(delay[:, ~odd], weight[:, ~odd], grown[:, ~odd])
    lag, lag_std = np.full(len(odd), whole), np.full(len(odd), whole_std)
    for mine, (mean, std) in zip(groups, own, strict=True):
        if odd[mine].any():
            lag[mine], lag_std[mine] = mean, math.hypot(std, usual)
    return lag, lag_std, odd


def _mean(delay: Real, weight: Real, common: Real) -> tuple[float, float]:
    """Return a weighted mean and its deviation; ``common`` does not average out."""
    total = float(weight.sum())
    if total <= 0.0:
        return 0.0, math.inf
    mean = float((weight * delay).sum() / total)
    used = np.count_nonzero(weight)
    scatter = float((weight * (delay - mean) ** 2).sum() / max(used - 1, 1))
    shared = float((weight * common).sum() / total)
    return mean, math.hypot(math.sqrt(max(1.0, scatter) / total), shared)
