"""Amplitude over frequency, raised around modes that would be worse known than the others."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# A mode gets at most this times the amplitude of its surroundings: the others must stay visible.
LARGEST_GAIN = 4.0
# Half widths of a raised stretch in units of the mode's half-power bandwidth, and at least.
STRETCH_BANDWIDTHS, LEAST_STRETCH_HZ = 2.0, 1.0
KNOTS = 121


@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of the band that needs more than the rest.

    Parameters
    ----------
    frequency_hz, damping_ratio : float [Hz], [-]
        Of its mode.
    shortfall : float
        How badly the mode would be known; the least of all stretches is not raised.
    std_hz : float [Hz]
        How uncertain its place is.
    """

    frequency_hz: float
    damping_ratio: float
    shortfall: float
    std_hz: float = 0.0

    @property
    def half_width_hz(self) -> float:
        """Half of its width: the mode wherever it may be, and its bell."""
        bell = 2.0 * STRETCH_BANDWIDTHS * self.damping_ratio * self.frequency_hz
        return max(LEAST_STRETCH_HZ, bell + 2.0 * self.std_hz)


@dataclass(frozen=True, slots=True)
class RaisedShape:
    """Amplitude over frequency.

    Parameters
    ----------
    frequency_hz, gain : (n_knots,) tuple [Hz], [-]
        As a request takes them.
    """

    frequency_hz: tuple[float, ...]
    gain: tuple[float, ...]


def raised_shape(band_hz: tuple[float, float], stretches: Sequence[Stretch]) -> RaisedShape:
    """Return the amplitude over a band, 1 but where a mode needs more.

    Parameters
    ----------
    band_hz : tuple of float [Hz]
        The band.
    stretches : sequence of Stretch
        At least one.
    """
    grid = np.geomspace(*band_hz, KNOTS)
    gain = np.ones_like(grid)
    best = min(each.shortfall for each in stretches)
    for each in stretches:
        wanted = min(LARGEST_GAIN, each.shortfall / best)
        away = np.abs(grid - each.frequency_hz) / each.half_width_hz
        near = 1.0 - np.clip(away - 1.0, 0.0, 1.0)
        gain = np.maximum(gain, 1.0 + (wanted - 1.0) * near)
    return RaisedShape(
        tuple(float(f) for f in np.round(grid, 6)), tuple(float(g) for g in np.round(gain, 6))
    )
