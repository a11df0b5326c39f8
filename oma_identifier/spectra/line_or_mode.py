"""How much more likely a coherent response is a line than a mode of light damping.

Both keep their phase over a record that is not long against the decay time 1 / (2π ζ f).  They
differ in how the phase is lost: random force turns the phasor of a mode as a random walk with a
pull to zero, rough at any time scale (Ornstein and Uhlenbeck); a machine's line is constant, or
its size and phase change smoothly.  Each is a complex Gaussian process with white noise beneath,
and the evidence for each is its likelihood averaged over what is not known: level of the noise,
frequency within a spectral line, rate of the decay or of the change.  The mean likelihood of lines
exceeds that of modes a hundredfold in at most one of a hundred modes, averaged over dampings.

References
----------
Uhlenbeck and Ornstein (1930), doi:10.1103/PhysRev.36.823;
Kass and Raftery (1995), doi:10.1080/01621459.1995.10476572 (odds from evidence).
"""

from dataclasses import dataclass
from functools import lru_cache
import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import toeplitz
from scipy.special import logsumexp

DECAYS = np.geomspace(0.05, 128.0, 20)
"""Decay times 2π ζ f T in the record that are tried."""
NARROW = 4.0 * math.pi
"""So many of a mode with ζfT = 2."""
SMOOTH = 2.0, 3.0, 4.5, 7.0, 10.0, 16.0
"""Segments over which a line changes that are tried."""
SHARES = 1e-3, 1e-2, 0.1, 1.0, 1e3
"""Power of the change over that of the constant part that are tried."""
SIGNAL_TO_NOISE = np.geomspace(1e-1, 1e7, 12)
"""Power of line or mode over that of the noise of a segment that are tried."""
OFFSETS = np.linspace(-1.0, 1.0, 13)
"""Errors of the frequency in spectral lines that are tried."""
FINE = 24

Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Odds:
    """What a coherent response is.

    Parameters
    ----------
    line : float
        Log odds of a line against a mode.
    narrow_mode : float
        Log odds of a mode with at most ``NARROW`` decay times in the record against a line, a
        broader mode, and noise.
    """

    line: float = math.inf
    narrow_mode: float = -math.inf


def odds_of(phasor: NDArray[np.complex128], least_decays: float) -> Odds:
    """Return the odds of what a response is.

    Parameters
    ----------
    phasor : (n_segments,) complex array
        Response in successive tapered segments, demodulated to within a spectral line.
    least_decays : float
        Decay times in the record of the mode that is least damped, 2π ζ f T.
    """
    evidence = _evidence(phasor)
    modes, constant = evidence[: len(DECAYS)], evidence[len(DECAYS)]
    line = np.logaddexp(constant, _log_mean(evidence[len(DECAYS) + 1 :])) - math.log(2.0)
    possible = np.minimum(least_decays, DECAYS[-1]) <= DECAYS
    narrow, broad = modes[possible & (DECAYS <= NARROW)], modes[possible & (DECAYS > NARROW)]
    return Odds(
        line=float(line - _log_mean(modes[possible])),
        narrow_mode=float(_log_mean(narrow) - np.logaddexp(line, _log_mean(broad))),
    )


def _log_mean(logs: Real) -> float:
    return float(logsumexp(logs)) - math.log(len(logs)) if len(logs) else -math.inf


def _evidence(phasor: NDArray[np.complex128]) -> Real:
    """Return the log likelihood under every kernel, averaged over level and frequency."""
    n_segments = len(phasor)
    values, vectors = _kernels(n_segments)
    middle = (np.arange(n_segments) + 0.5) / n_segments
    turned = phasor[:, None] * np.exp(-2j * np.pi * np.outer(middle, OFFSETS))
    # One product for all kernels: (kernels, values, offsets).
    parts = vectors.transpose(0, 2, 1).reshape(-1, n_segments)
    parts = parts @ np.hstack([turned.real, turned.imag])
    power = (parts**2).reshape(len(values), n_segments, 2, len(OFFSETS)).sum(axis=2)
    variance = 1.0 + SIGNAL_TO_NOISE[:, None] * values[:, None, :]
    # The scale that fits best, as its prior is the same for all.
    misfit = (1.0 / variance) @ power
    logs = -np.log(variance).sum(axis=-1)[..., None] - n_segments * np.log(misfit)
    return np.asarray(logsumexp(logs, axis=(1, 2)) - math.log(logs[0].size))


@lru_cache(maxsize=4)
def _kernels(n_segments: int) -> tuple[Real, Real]:
    """Return eigenvalues and eigenvectors of the correlations of modes, then of lines."""
    lag = np.arange(n_segments)
    apart = np.abs(lag[:, None] - lag)
    constant = np.ones(apart.shape)
    modes = [_decaying(decays, n_segments) for decays in DECAYS]
    lines = [constant]
    for length in SMOOTH:
        change = np.exp(-0.5 * (apart / length) ** 2)
        lines += [(constant + share * change) / (1.0 + share) for share in SHARES]
    values, vectors = np.linalg.eigh(np.array(modes + lines))
    return np.maximum(values, 0.0), vectors


def _decaying(decays: float, n_segments: int) -> Real:
    """Return the correlation of a mode's phasors, averaged over tapered segments."""
    within = (np.arange(FINE) + 0.5) / FINE
    taper = np.blackman(FINE + 2)[1:-1] / np.blackman(FINE + 2)[1:-1].sum()
    lags = within[:, None] - within + np.arange(n_segments)[:, None, None]
    decayed = np.exp(-decays / n_segments * np.abs(lags))
    return np.asarray(toeplitz(decayed @ taper @ taper))
