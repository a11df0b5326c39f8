"""The bandwidth of a complex envelope: of a mode under white force, with white noise."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Bandwidth:
    """What the spectrum of an envelope is.

    Parameters
    ----------
    half_width_hz : float [Hz]
        Half the half-power bandwidth: ζ f of a linear mode.
    noise_share : float
        Of the power in the band that is no peak, 0 to 1.
    """

    half_width_hz: float
    noise_share: float


def bandwidth(envelopes: Sequence[Complex], rate_hz: float, carrier_hz: float) -> Bandwidth:
    """Return the bandwidth of parts of one envelope by Whittle's likelihood.

    Parameters
    ----------
    envelopes : sequence of complex arrays
        Evenly sampled, in the lowest rate that holds the band.
    rate_hz : float [Hz]
    carrier_hz : float [Hz]
        Frequency that the envelopes are about.

    References
    ----------
    Whittle (1953), doi:10.1007/BF02590998.
    """
    hz = np.concatenate([np.fft.fftfreq(len(each), 1.0 / rate_hz) for each in envelopes])
    power = np.concatenate([np.abs(np.fft.fft(each)) ** 2 / len(each) for each in envelopes])
    power /= power.mean()
    start_hz = _spread(hz, power)

    def shape_of(parameters: NDArray[np.float64]) -> NDArray[np.float64]:
        width, noise = np.exp(parameters[:2])
        own_hz, at_hz = carrier_hz + parameters[2] * start_hz, carrier_hz + hz
        # Of a displacement, about 1 at its peak; flanks of a broad one are not alike.
        away = (own_hz**2 - at_hz**2) ** 2 + (2.0 * width * at_hz) ** 2
        return np.asarray((2.0 * width * own_hz) ** 2 / away + noise)

    def misfit(parameters: NDArray[np.float64]) -> float:
        shape = shape_of(parameters)
        return float(math.log(np.mean(power / shape)) + np.mean(np.log(shape)))

    start = np.array([math.log(start_hz), math.log(1e-3), 0.0])
    limits = [(start[0] - 7.0, start[0] + 7.0), (-20.0, 3.0), (-3.0, 3.0)]
    found = minimize(misfit, start, method='Nelder-Mead', bounds=limits, options=OPTIONS).x
    noise = float(np.exp(found[1]) / np.mean(shape_of(found)))
    return Bandwidth(float(np.exp(found[0])), noise)


OPTIONS = {'xatol': 1e-4, 'fatol': 1e-9, 'maxiter': 2000}


def _spread(hz: NDArray[np.float64], power: NDArray[np.float64]) -> float:
    """Return half the width around zero that holds half the power."""
    order = np.argsort(np.abs(hz))
    share = np.cumsum(power[order]) / power.sum()
    return float(max(np.abs(hz[order])[np.searchsorted(share, 0.5)], np.abs(hz[order])[1]))
