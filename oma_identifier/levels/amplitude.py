"""The half-width of a mode by the amplitude of its motion alone, whatever its frequency does.

An envelope a of a mode under white force obeys ȧ = -(γ + iδ) a + w.  What changes the frequency,
δ, turns a and leaves |a| as it is, and w stays white when turned back with it.  So the amplitude
has no part of what other modes do to the stiffness of this one as they come and go, which widens
its peak as damping would: the flank of its spectrum tells the power w that drives it, which
damping takes out again, 2 γ E[|a|²].

References
----------
Rice (1945), doi:10.1002/j.1538-7305.1945.tb00453.x: the covariance of |a| is that of a hyper-
geometric function of the squared correlation of a, E[|a|²] π/4 (₂F₁(-½, -½; 1; ρ²) - 1).
Whittle (1953), doi:10.1007/BF02590998.
"""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import hyp2f1

Real = NDArray[np.float64]
SQUARE = np.linspace(0.0, 1.0, 2001)
RAYLEIGH = (hyp2f1(-0.5, -0.5, 1.0, SQUARE) - 1.0) / (4.0 / math.pi - 1.0)
"""Correlation of the amplitude, over the squared one of the envelope."""
VARIANCE = 1.0 - math.pi / 4.0
"""Of the amplitude, over its mean square."""
LINES = 1024
"""Of a model of the spectrum: 64 in the half-width of a mode with 8 of them on either side."""
WIDEST, NARROWEST = 0.5, 2.5e-3
"""Half-widths that are tried, over the rate of the envelope: the one of a mode is 1/16 of it."""


def amplitude_half_width(
    envelopes: Sequence[NDArray[np.complex128]],
    rate_hz: float,
    noise_share: float,
    carrier_hz: float = math.inf,
    colour: float = 0.0,
) -> float:
    """Return the half-width [Hz] that the amplitude tells, ζ f of a linear mode.

    Parameters
    ----------
    envelopes : sequence of complex arrays
        Parts of one, evenly sampled, in the lowest rate that holds the band.
    rate_hz : float [Hz]
    noise_share : float
        Of the power in the band that is no peak, 0 to 1.
    carrier_hz : float [Hz]
        Frequency that the envelopes are about; above half their rate.
    colour : float
        Power of frequency that the force goes with.
    """
    away_hz = np.asarray(np.fft.fftfreq(LINES, 1.0 / rate_hz), float)
    over = away_hz / carrier_hz
    # The flanks of a displacement are not alike, those under a coloured force still less.
    tilt = (1.0 + over) ** colour / (1.0 + 0.5 * over) ** 2
    amplitudes = [np.abs(each) for each in envelopes]
    lines = [np.asarray(np.fft.rfftfreq(len(a), 1.0 / rate_hz), float) for a in amplitudes]
    hz = np.concatenate([_above_zero(each) for each in lines])
    power = np.concatenate([_above_zero(np.abs(np.fft.rfft(a)) ** 2 / len(a)) for a in amplitudes])

    def shape_of(half_width_hz: float) -> Real:
        return np.asarray(np.interp(hz, *_spectrum(half_width_hz, away_hz, tilt, noise_share)))

    def misfit(logarithm: float) -> float:
        shape = shape_of(math.exp(logarithm))
        return float(math.log(np.mean(power / shape)) + np.mean(np.log(shape)))

    ends = (math.log(NARROWEST * rate_hz), math.log(WIDEST * rate_hz))
    found = math.exp(minimize_scalar(misfit, bounds=ends, options={'xatol': 1e-3}).x)
    # Of a linear mode the variance is that of Rayleigh's law; else the flank alone counts.
    variance = float(np.mean(power / shape_of(found)))
    square = float(np.mean(np.concatenate(amplitudes) ** 2))
    return found * variance / (VARIANCE * square)


def _above_zero(lines: Real) -> Real:
    """Leave out the mean, and the middle of the rate."""
    return lines[1 : (len(lines) * 2 - 1) // 2]


def _spectrum(half_width_hz: float, hz: Real, tilt: Real, noise_share: float) -> tuple[Real, Real]:
    """Return lines [Hz] and the spectrum there of an amplitude of variance one."""
    peak = tilt / (1.0 + (hz / half_width_hz) ** 2)
    envelope = (1.0 - noise_share) * peak / peak.mean() + noise_share
    square = np.minimum(np.abs(np.fft.ifft(envelope)) ** 2, 1.0)
    own = np.fft.fft(np.interp(square, SQUARE, RAYLEIGH)).real
    return hz[: LINES // 2], own[: LINES // 2]
