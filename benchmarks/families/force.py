"""Forces: their spectra and how strong they are over time."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Spectrum = Callable[[NDArray[np.float64]], NDArray[np.float64]]
Envelope = NDArray[np.float64]


def draw_spectrum(
    rng: np.random.Generator, kind: str, lowest_hz: float, highest_hz: float
) -> Spectrum:
    """Draw the amplitude of the forces over frequency: ``white``, ``coloured`` or ``banded``."""
    if kind == 'coloured':
        slope = rng.uniform(-0.5, 1.5)
        corner = np.exp(rng.uniform(np.log(lowest_hz), np.log(highest_hz)))
        return lambda hz: (1.0 + (hz / corner) ** 2) ** (-0.5 * slope)
    if kind == 'banded':
        low, high = np.exp(np.sort(rng.uniform(np.log(lowest_hz), np.log(highest_hz), 2)))
        low, high = 0.8 * low, 1.25 * high
        # A floor 40 dB below, for no real excitation ends altogether.
        return lambda hz: (
            0.01
            + 1.0 / np.sqrt((1.0 + (low / np.maximum(hz, 1e-9)) ** 8) * (1.0 + (hz / high) ** 8))
        )
    return np.ones_like


def draw_envelope(rng: np.random.Generator, kind: str, n_samples: int) -> Envelope:
    """Draw the strength of the forces over the record: ``steady``, ``growing`` or ``bursting``."""
    share = np.arange(n_samples) / n_samples
    if kind == 'growing':
        growth = float(np.log(rng.uniform(2.0, 10.0)) * rng.choice([-1.0, 1.0]))
        return np.asarray(np.exp(growth * share))
    if kind == 'bursting':
        centres = rng.uniform(0.0, 1.0, int(rng.integers(3, 15)))
        widths = np.exp(rng.uniform(np.log(0.005), np.log(0.1), len(centres)))
        bumps = np.exp(-0.5 * ((share[:, None] - centres) / widths) ** 2)
        return np.asarray(0.05 + bumps.sum(axis=1))
    return np.ones(n_samples)
