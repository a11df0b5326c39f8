"""What turns the residues of real modes: the measuring chain."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit import free_fit
from impact_testing.responses import PointData

Real = NDArray[np.float64]


def common_phases(data: Sequence[PointData], pole: NDArray[np.complex128]) -> tuple[Real, Real]:
    """Return the phase that the residues of each mode have in common, modulo half a turn.

    Parameters
    ----------
    data : sequence of PointData
    pole : (n_poles,) complex array [rad/s]

    Returns
    -------
    phase : (n_poles,) array [rad]
        By which responses are ahead, the force late; 0 of real modes.
    std : (n_poles,) array [rad]
        What noise makes of it, nearly: by the power of a mode's own lines over that of the noise.
    """
    squares, power = np.zeros(len(pole), complex), np.zeros(len(pole))
    for point, each in zip(free_fit(data, pole), data, strict=True):
        line = np.searchsorted(each.frequency_hz, np.abs(pole) / (2.0 * np.pi))
        noise = each.course[np.minimum(line, len(each.course) - 1)][:, None] * each.level
        squares += np.sum((2j * pole.imag / pole**2)[:, None] ** 2 * point.amplitude**2, axis=1)
        power += np.sum(np.abs(point.amplitude) ** 2 / noise, axis=1)
    # Lines lie 1 / T apart: Σ 1 / |jω - p|² = T / (2 |Re p|).
    length_s = data[0].frf.spectra.length_s
    power *= length_s / (2.0 * np.abs(pole.real))
    return np.asarray(0.5 * np.angle(squares)), np.asarray(
        1.0 / np.sqrt(np.maximum(power, 1e-300))
    )
