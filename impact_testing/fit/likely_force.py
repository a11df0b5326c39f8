"""The force of the taps where its sensor has noise, by what the structure answered.

The noise of the force is common to all channels: it makes every FRF of a point wrong by one factor
that changes slowly over frequency.  Taken for noise of the responses it is far too little where
they are strong, so that modes would be added that explain it.  The responses to a force that a
model of the structure predicts say what the force was; what its sensor read says it too, with the
noise that it has without taps.

Both are weighed tap by tap.  What the taps have in common is left to the fit in the end, as
unknowns with the deviations that the noise gives them, about where it is most likely: else masses
would be surer than the force is.

References
----------
Pintelon and Schoukens (2012), System Identification, 2nd ed., doi:10.1002/9781118287422, chapter 8
(errors in variables).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit.modal_model import Doubts, remainder, residual
from impact_testing.responses import apart, PointData, PointFrf, Pulse

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
MOST_ABSORBED = 0.5
"""Of the responses' noise: more says that there are too few lines."""
LEAST_DOUBT = 0.01
"""Least sum of squares, in units of the noise, that an unknown of the force's noise adds.  One
that adds less moves no value by more than a tenth of its own deviation (Cauchy and Schwarz).  A
hundredth of it changed neither coverage (168 values of
twelve unseen structures) nor the rms errors over σ, to two digits."""


def with_likely_force(
    data: PointData, measured: PointData, pole: Complex, amplitude: Complex
) -> PointData:
    """Return a point with the forces that are most likely by sensor and responses.

    The noise stays as it is; it is less with them.

    Parameters
    ----------
    data : PointData
        As it stands, with its noise.
    measured : PointData
        With the forces as they were read.
    pole : (n_poles,) complex array [rad/s]
    amplitude : (n_poles, n_channels) complex array
        Of accelerances.
    """
    read = measured.frf.spectra
    noise_n = read.force_noise_n
    if noise_n == 0.0:
        return data
    answers = _Answers.of(data, pole, amplitude)
    power = data.course * data.frf.force_power[data.lines]
    weight = 1.0 / np.sqrt(power[:, None] * data.level)
    answer = read.force[:, data.lines, None] * answers.direct
    answer = answer + read.free_motion(pole, amplitude, data.lines)
    left = iter((read.motion[:, data.lines] - answer) * weight)
    sizes = [
        len(pulse.force_n) for pulse, tap in zip(read.pulses, read.taps, strict=True) if tap.good
    ]
    # What a newton in one sample adds is the same for all taps.
    columns = answers.columns(max(sizes), weight)
    both = apart(columns.reshape(-1, columns.shape[2]))
    gram = both.T @ both
    found = [
        _likely(gram[:size, :size], both[:, :size].T @ apart(next(left).reshape(-1)), noise_n)
        for size in sizes
    ]
    corrections = iter([each for each, _ in found])
    pulses = [
        Pulse(pulse.first, pulse.force_n + next(corrections)) if tap.good else pulse
        for pulse, tap in zip(read.pulses, read.taps, strict=True)
    ]
    fresh = replace(data, frf=PointFrf(read.with_force(pulses)))
    values = 2 * weight.size
    return replace(
        fresh,
        corrected_n=_in_common([each for each, _ in found], _sizes(fresh)),
        absorbed=min(MOST_ABSORBED, float(np.mean([taken for _, taken in found])) / values),
    )


def _likely(gram: Real, seen: Real, noise_n: float) -> tuple[Real, float]:
    """Return the mean of the posterior of what one tap's force is more, and how much it fits."""
    inverse = np.linalg.inv(gram + np.eye(len(gram)) / noise_n**2)
    return inverse @ seen, float(np.sum(inverse * gram))


def _in_common(changes: Sequence[Real], size: Real) -> Real:
    """Return what changes of the taps' forces have in common, as of a tap of size one."""
    common = np.zeros(max(map(len, changes)))
    for each, weight in zip(changes, size, strict=True):
        common[: len(each)] += weight * each
    return common


def force_doubt(data: PointData) -> Real:
    """Return the relative variance that the force's noise gives FRFs, (n_lines,) array.

    Half of it is in the real, half in the imaginary part.
    """
    spectra = data.frf.spectra
    longest = max(len(pulse.force_n) for pulse in spectra.pulses)
    power = longest * (spectra.force_noise_n / spectra.record.rate_hz) ** 2
    return np.asarray(power / data.frf.force_power[data.lines])


def force_doubts(data: PointData, pole: Complex, amplitude: Complex) -> Doubts:
    """Return what common noise of the forces adds to a point, without residual terms' part."""
    spectra = data.frf.spectra
    noise_n = spectra.force_noise_n
    if noise_n == 0.0:
        return Doubts.none(data)
    size, longest = _sizes(data), max(len(pulse.force_n) for pulse in spectra.pulses)
    # The mean of the taps, as if all were of one form.
    mean = size @ spectra.force[:, data.lines] / float(size @ size)
    weight = 1.0 / np.sqrt(data.course[:, None] * data.level) / mean[:, None]
    added = apart(_Answers.of(data, pole, amplitude).columns(longest, weight))
    added *= noise_n / float(np.linalg.norm(size))
    _, _, directions = remainder(data, pole, amplitude)
    flat = added.reshape(len(added), -1)
    flat = flat - directions @ (directions.T @ flat)
    flat = flat.reshape(-1, added.shape[2])
    size_squared, turn = np.linalg.eigh(flat.T @ flat)
    orthogonal = (flat @ turn[:, size_squared > LEAST_DOUBT]).reshape(*added.shape[:2], -1)
    taken = np.zeros(added.shape[2])
    taken[: len(data.corrected_n)] = data.corrected_n / noise_n
    return Doubts(orthogonal, (flat @ taken).reshape(added.shape[:2]))


def _sizes(data: PointData) -> Real:
    """Return how large the taps are beside each other, (n_taps,) array."""
    force = data.frf.spectra.force[:, data.lines]
    return np.asarray(np.linalg.norm(force, axis=1) / np.linalg.norm(force))


@dataclass(frozen=True)
class _Answers:
    """What a model answers to forces at a point, at the lines of the band.

    Parameters
    ----------
    data : PointData
    pole : (n_poles,) complex array [rad/s]
        Without the decay of an exponential window.
    bells : (n_lines, n_channels, 2 n_poles) complex array
        Of the poles, then of their conjugates, times their amplitudes.
    direct : (n_lines, n_channels) complex array
        FRFs.
    """

    data: PointData
    pole: Complex
    bells: Complex
    direct: Complex

    @classmethod
    def of(cls, data: PointData, pole: Complex, amplitude: Complex) -> '_Answers':
        windowed = pole - data.frf.spectra.decay_1_s
        windowed = np.concatenate([windowed, windowed.conj()])
        s = 2j * np.pi * data.frequency_hz[:, None]
        both = np.concatenate([amplitude, amplitude.conj()])
        bells = (1.0 / (s - windowed))[:, None, :] * both.T
        return cls(data, pole, bells, bells.sum(axis=2) + residual(data, pole, amplitude))

    def columns(self, n_samples: int, weight: NDArray[np.inexact]) -> Complex:
        """Return what a newton in each sample of a pulse adds, (n_lines, n_channels, n) array."""
        spectra = self.data.frf.spectra
        rate_hz, windowed = spectra.record.rate_hz, self.pole - spectra.decay_1_s
        time_s = np.arange(n_samples) / rate_hz
        turn = np.exp(-(2j * np.pi * self.data.frequency_hz[:, None] + spectra.decay_1_s) * time_s)
        left = -np.exp((windowed * spectra.length_s)[:, None] - self.pole[:, None] * time_s)
        weight = (weight / rate_hz)[:, :, None]
        bells = (self.bells * weight).reshape(-1, self.bells.shape[2])
        found = bells @ np.concatenate([left, left.conj()])
        found = found.reshape(*self.direct.shape, n_samples)
        found += (self.direct[:, :, None] * weight) * turn[:, None, :]
        return np.asarray(found)
