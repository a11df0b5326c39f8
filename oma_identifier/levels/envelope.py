"""The peak of a complex envelope: of a mode under a coloured force, with white noise."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
OPTIONS = {'xatol': 1e-4, 'fatol': 1e-9, 'maxiter': 4000}


@dataclass(frozen=True, slots=True)
class Peak:
    """What the spectrum of an envelope is.

    Parameters
    ----------
    half_width_hz : float [Hz]
        Half the half-power bandwidth: ζ f of a linear mode.
    noise_share : float
        Of the power in the band that is no peak, 0 to 1.
    centre_hz : float [Hz]
        Natural frequency of a linear mode.
    colour, colour_std : float
        Power of frequency that flanks go with beside those of a mode under a white force, and its
        standard deviation; 0 where it was given.
    """

    half_width_hz: float
    noise_share: float
    centre_hz: float
    colour: float = 0.0
    colour_std: float = 0.0


def peak(
    envelopes: Sequence[Complex], rate_hz: float, carrier_hz: float, colour: float | None = 0.0
) -> Peak:
    """Return the peak of parts of one envelope by Whittle's likelihood.

    Parameters
    ----------
    envelopes : sequence of complex arrays
        Evenly sampled, in the lowest rate that holds the band.
    rate_hz : float [Hz]
    carrier_hz : float [Hz]
        Frequency that the envelopes are about.
    colour : float or None
        Power of frequency that the force goes with; None: to be found.

    References
    ----------
    Whittle (1953), doi:10.1007/BF02590998.
    """
    hz = np.concatenate([np.fft.fftfreq(len(each), 1.0 / rate_hz) for each in envelopes])
    power = np.concatenate([np.abs(np.fft.fft(each)) ** 2 / len(each) for each in envelopes])
    power /= power.mean()
    start_hz = _spread(hz, power)
    at_hz = carrier_hz + hz
    octaves = np.log(at_hz / carrier_hz)

    def shape_of(parameters: Real) -> Real:
        width, noise = np.exp(parameters[:2])
        own_hz = carrier_hz + parameters[2] * start_hz
        # Of a displacement, about 1 at its peak; flanks of a broad one are not alike.
        away = (own_hz**2 - at_hz**2) ** 2 + (2.0 * width * at_hz) ** 2
        alike = (2.0 * width * own_hz) ** 2 / away
        exponent = parameters[3] if colour is None else colour
        return np.asarray(alike * np.exp(exponent * octaves) + noise)

    def misfit(parameters: Real) -> float:
        shape = shape_of(parameters)
        return float(math.log(np.mean(power / shape)) + np.mean(np.log(shape)))

    n = 4 if colour is None else 3
    start = np.array([math.log(start_hz), math.log(1e-3), 0.0, 0.0])[:n]
    limits = [(start[0] - 7.0, start[0] + 7.0), (-20.0, 3.0), (-3.0, 3.0), (-16.0, 16.0)][:n]
    found = minimize(misfit, start, method='Nelder-Mead', bounds=limits, options=OPTIONS).x
    return Peak(
        float(np.exp(found[0])),
        float(np.exp(found[1]) / np.mean(shape_of(found))),
        carrier_hz + float(found[2]) * start_hz,
        float(found[3]) if colour is None else colour,
        _last_std(shape_of, found) if colour is None else 0.0,
    )


def _last_std(shape_of: Callable[[Real], Real], found: Real) -> float:
    """Return the standard deviation of the last parameter, height unknown (Fisher information)."""
    steps = 1e-3 * np.eye(len(found))
    change = np.column_stack(
        [np.log(shape_of(found + step) / shape_of(found - step)) / 2e-3 for step in steps]
    )
    change -= change.mean(axis=0)
    others, last = change[:, :-1], change[:, -1]
    left = last - others @ np.linalg.lstsq(others, last)[0]
    return 1.0 / max(float(np.linalg.norm(left)), 1e-12)


def _spread(hz: Real, power: Real) -> float:
    """Return half the width around zero that holds half the power."""
    order = np.argsort(np.abs(hz))
    share = np.cumsum(power[order]) / power.sum()
    return float(max(np.abs(hz[order])[np.searchsorted(share, 0.5)], np.abs(hz[order])[1]))
