"""A structure with known modes, shaken by white forces: the truth most tests compare with."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.linalg import expm

from modal_core.channel import Channel
from modal_core.samples import Samples


@dataclass(frozen=True)
class Structure:
    """Modes with real shapes; accelerations come from its exact zero-order-hold state space."""

    frequency_hz: np.ndarray
    damping_ratio: np.ndarray
    shapes: np.ndarray

    def simulate(self, rng, duration_s, rate_hz, noise=0.05, oversample=4):
        """Return Samples: every mode has its own white force, constant over a fine step."""
        fine = rate_hz * oversample
        n = int(duration_s * fine)
        responses = []
        for hz, zeta in zip(self.frequency_hz, self.damping_ratio, strict=True):
            force = rng.standard_normal(n + 2000)
            responses.append(_sdof(hz, zeta, fine, force)[2000:])
        response = np.array(responses)
        response /= response.std(axis=1, keepdims=True)
        # Plain picking aliases what is above half the rate: only the white direct term is there.
        clean = (self.shapes @ response).T[::oversample]
        noisy = clean + noise * clean.std(axis=0) * rng.standard_normal(clean.shape)
        names = tuple(Channel(name=f'c{index}') for index in range(clean.shape[1]))
        return Samples(noisy, rate_hz, names)


def _sdof(hz, zeta, rate_hz, force):
    """Velocity of one oscillator under a force held constant over each step."""
    omega = 2 * np.pi * hz
    a = np.array([[0, 1], [-(omega**2), -2 * zeta * omega]])
    system = expm(np.block([[a, np.array([[0], [1]])], [np.zeros((1, 3))]]) / rate_hz)
    ad, bd = system[:2, :2], system[:2, 2]
    from scipy.signal import lfilter

    # Second-order recursion of the velocity: c (zI - Ad)^-1 Bd.
    characteristic = np.poly(ad)
    adjugate = np.array([[0.0, 0.0, 0.0], [0.0, bd[1], ad[1, 0] * bd[0] - ad[0, 0] * bd[1]]])
    return lfilter(adjugate[1], characteristic, force)


@pytest.fixture(scope='session')
def structure():
    """Return a function that makes a structure with well-separated random shapes."""

    def make(frequency_hz, damping_ratio, n_channels=6, seed=0):
        rng = np.random.default_rng(seed)
        shapes = rng.standard_normal((n_channels, len(frequency_hz)))
        if n_channels >= len(frequency_hz):
            shapes = np.linalg.qr(shapes)[0] * np.sqrt(n_channels)
        return Structure(np.array(frequency_hz), np.array(damping_ratio), shapes)

    return make
