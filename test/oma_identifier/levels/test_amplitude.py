"""The half-width by the amplitude alone: no change of frequency touches it."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from oma_identifier.levels.amplitude import amplitude_half_width
from oma_identifier.levels.envelope import peak

HALF_WIDTH_HZ, RATE_HZ, BAND = 0.2, 12.8, 8.0
DURATION_S = 2000.0


def white(rng, n):
    """Return circular white noise."""
    return rng.standard_normal(n) + 1j * rng.standard_normal(n)


def envelope(seed, wander):
    """Return a linear mode's envelope within eight half-widths, exact in steps of RATE_HZ.

    Its frequency follows the power of another mode of the same width, ``wander`` half-widths on
    average: a white force stays white when it is turned.
    """
    rng = np.random.default_rng(seed)
    n, step = round(DURATION_S * RATE_HZ), 1.0 / RATE_HZ
    decay = math.exp(-2.0 * math.pi * HALF_WIDTH_HZ * step)
    linear, other = (lfilter([1.0], [1.0, -decay], white(rng, n)) for _ in range(2))
    power = np.abs(other) ** 2
    moved_hz = wander * HALF_WIDTH_HZ * (power / power.mean() - 1.0)
    turned = linear * np.exp(2j * np.pi * np.cumsum(moved_hz) * step)
    lines = np.fft.fft(turned)
    hz = np.fft.fftfreq(n, step)
    order = np.argsort(hz)
    inside = order[np.abs(hz[order]) < BAND * HALF_WIDTH_HZ]
    kept = np.roll(lines[inside], -(len(inside) // 2))
    return np.fft.ifft(kept) * len(kept) / n, RATE_HZ * len(kept) / n


@pytest.mark.parametrize('wander', [0.0, 1.0, 2.0])
def test_a_frequency_that_wanders_widens_the_peak_and_leaves_the_amplitude(wander):
    """Ten records of ζ f T = 400: the mean is known to 0.04 / √10 times 2."""
    alone, wide = [], []
    for seed in range(10):
        found, rate_hz = envelope(seed, wander)
        alone.append(amplitude_half_width([found], rate_hz, 0.0) / HALF_WIDTH_HZ)
        wide.append(peak([found], rate_hz, 1000.0).half_width_hz / HALF_WIDTH_HZ)
    said = f'seeds 0 to 9: {np.mean(alone):.3f}, {np.mean(wide):.3f}'
    assert np.mean(alone) == pytest.approx(1.0, abs=0.05), said
    assert (np.mean(wide) > 1.1) == (wander > 0.0), said
