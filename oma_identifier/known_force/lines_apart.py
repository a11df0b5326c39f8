"""Lines of a measured force, and what lies between them, as two forces.

A sensor of a cutting force reads the teeth far above its own noise, and chips that break between
their lines about as strong as that.  Measured f = s + n, of a force s and noise n, is at each
frequency best read as κ f, κ = S_ss / (S_ss + S_nn), with an error that nothing measured holds:
on lines κ is one, between them less.  One regression on f takes κ for one, and what is left is no
noise: where lines can be told in advance from their past, n is what was not, so that the past of
force tells of it and moves the poles.  As two inputs each has a gain of its own; no κ need be
known.  Noise that is as strong everywhere beside the force needs no parting.

The filter is the same for all times; within half its length of the ends there is no answer.

References
----------
Söderström (2007), Errors-in-variables methods in system identification,
doi:10.1016/j.automatica.2006.11.025; Carroll, Ruppert, Stefanski and Crainiceanu (2006),
Measurement Error in Nonlinear Models, doi:10.1201/9781420010138, chapter 4 (calibration).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, percentile_filter
from scipy.signal import oaconvolve, welch

Real = NDArray[np.float64]
LONGEST_S, SHARE = 8.0, 0.15
"""Length of the filter [s], and of the record: both ends lose half of it."""
OVER = 10.0
"""Power of a line over what is around it, to either side.  Of twelve or more half overlapping
segments chance gives that at fewer than one of 1e15 frequencies."""
LEAST = 1e-3
"""Of the mean power: below, side lobes of filters rise over what is around them."""
AROUND_HZ, LOWER = 3.0, 25
"""Width of what is around to either side, and the percentile of it that lines do not reach [%]."""


def lines_apart(force: Real, rate_hz: float) -> tuple[Real, slice]:
    """Return lines of a force and the rest of it.

    Parameters
    ----------
    force : (n_samples, n_forces) array
    rate_hz : float [Hz]

    Returns
    -------
    (n_samples, n_parts) array
        Lines and rest in turn of each force that has lines, the others as they are.
    slice
        Rows of which that is known.
    """
    half = int(min(LONGEST_S, SHARE * len(force) / rate_hz) * rate_hz / 2.0)
    parts, known = [], slice(0, len(force))
    for column in (force - force.mean(axis=0)).T:
        lined = _on_lines(column, rate_hz, 2 * half) if half else np.zeros(0, dtype=bool)
        if not lined.any():
            parts.append(column)
            continue
        lines = oaconvolve(column, _kernel(lined), 'same')
        parts += [lines, column - lines]
        known = slice(half, len(force) - half)
    return np.column_stack(parts), known


def _on_lines(force: Real, rate_hz: float, size: int) -> NDArray[np.bool_]:
    """Return which of the frequencies of a segment lie on a line or beside it."""
    power = welch(force, rate_hz, 'hann', size)[1]
    half = max(1, round(0.5 * AROUND_HZ * size / rate_hz))
    # Both sides: beside the end of a band one of them is high.
    below, above = (
        percentile_filter(power, LOWER, 2 * half + 1, origin=side * half) for side in (1, -1)
    )
    around = np.maximum(np.maximum(below, above), LEAST * power.mean())
    return np.asarray(maximum_filter1d(power > OVER * around, 3))


def _kernel(passed: NDArray[np.bool_]) -> Real:
    """Return the symmetric filter that passes some frequencies."""
    response = np.fft.fftshift(np.fft.irfft(passed.astype(float)))
    kernel = np.append(response, response[0])
    return np.asarray(kernel * np.hanning(len(kernel)))
