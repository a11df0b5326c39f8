"""Frequency bands: one block Hankel matrix sees about two octaves well, so the band is split.

A Hankel matrix of p block rows spans p samples.  At 100 Hz and 20 block rows that is less than
half a period of a 1.9 Hz mode, so each quarter of the frequency axis is identified from data
decimated to match.  The split follows from rate and length alone; no knob is needed.
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import IdentificationError
from oma_identifier.covariance.thresholds import COVARIANCE
from oma_identifier.settings import IdentificationSettings

STEP = 4
"""Decimation from one band to the next below."""


@dataclass(frozen=True, slots=True)
class Band:
    """One frequency band.

    Parameters
    ----------
    factors : tuple of int
        Decimation stages from the sample rate to the band's own rate.
    sample_rate_hz : float [Hz]
        Rate after decimation.
    low_hz, high_hz : float [Hz]
        Poles outside are left to another band.
    high_pass_hz : float [Hz]
        Corner of the filter that removes drift, gravity, rigid motion and lower bands.
    """

    factors: tuple[int, ...]
    sample_rate_hz: float
    low_hz: float
    high_hz: float
    high_pass_hz: float

    def sees(self, frequency_hz: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which lines the filters of the band do not take out of it, (n_lines,) array."""
        seen = (frequency_hz > COVARIANCE.seen[0] * self.high_pass_hz) & (
            frequency_hz < COVARIANCE.seen[1] * self.sample_rate_hz
        )
        return np.asarray(seen)


def plan_bands(
    sample_rate_hz: float, duration_s: float, settings: IdentificationSettings
) -> tuple[Band, ...]:
    """Split the analysed band, highest first.

    Raises
    ------
    IdentificationError
        The record is too short, or too slow, for the frequencies asked for.
    """
    low = settings.min_frequency_hz or 0.0
    low = max(low, COVARIANCE.periods / duration_s)
    high = COVARIANCE.upper_undecimated * sample_rate_hz
    if settings.max_frequency_hz is not None:
        high = min(high, settings.max_frequency_hz)
    if low >= high:
        raise IdentificationError(
            f'{duration_s:.3g} s at {sample_rate_hz:.4g} Hz are too short',
            found=f'lowest identifiable frequency {low:.3g} Hz',
            expected=f'< {high:.3g} Hz',
        )
    return tuple(_split(sample_rate_hz, duration_s, low, high))


def _split(sample_rate_hz: float, duration_s: float, low: float, high: float) -> list[Band]:
    factors = tuple(_stages(int(COVARIANCE.upper * sample_rate_hz / high)))
    rate = sample_rate_hz / math.prod(factors)
    bands: list[Band] = []
    while True:
        top = min(high, (COVARIANCE.upper if factors else COVARIANCE.upper_undecimated) * rate)
        # A band of few samples allows no model order: the one above does better.
        last = (
            low >= COVARIANCE.lower * rate or duration_s * rate / STEP < COVARIANCE.fewest_samples
        )
        bottom = low if last else COVARIANCE.lower * rate
        corner = 0.5 * bottom if last else COVARIANCE.high_pass * rate
        bands.append(Band(factors, rate, bottom, top, corner))
        if last:
            return bands
        factors, rate = (*factors, STEP), rate / STEP


def _stages(factor: int) -> list[int]:
    """Split a decimation factor into stages of at most 10; their product may fall short of it."""
    stages: list[int] = []
    while factor > 10:
        stages.append(8)
        factor //= 8
    return [*stages, factor] if factor > 1 else stages
