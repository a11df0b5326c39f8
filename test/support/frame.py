"""A frame of three floors whose modes are known in closed form, shaken by noise."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

STIFFNESS_N_M, MASS_KG, DAMPING_RATIO = 2.0e6, 400.0, 0.012
FLOORS = ('ground.x', 'middle.x', 'roof.x')


@dataclass(frozen=True)
class Frame:
    """Truth and accelerations."""

    frequencies_hz: np.ndarray
    shapes: np.ndarray
    acceleration: np.ndarray
    sample_rate_hz: float


def shaken_frame(seed: int, sample_rate_hz: float = 100.0, duration_s: float = 300.0) -> Frame:
    """Return three floors in a row: f_k = sqrt(k/m)/π sin((2k-1)π/14), shapes sin((2k-1)jπ/7).

    Each mode is shaken by a noise of its own; sensors add 2 % noise.
    """
    rng = np.random.default_rng(seed)
    order = 2 * np.arange(1, 4) - 1
    frequencies_hz = np.sqrt(STIFFNESS_N_M / MASS_KG) / np.pi * np.sin(order * np.pi / 14)
    shapes = np.sin(np.outer(np.arange(1, 4), order) * np.pi / 7)
    omega = 2 * np.pi * frequencies_hz
    s = omega * (-DAMPING_RATIO + 1j * np.sqrt(1 - DAMPING_RATIO**2))
    n_samples = round(sample_rate_hz * duration_s)
    modal = []
    for pole in np.exp(s / sample_rate_hz):
        motion = lfilter(
            [1.0], [1.0, -2 * pole.real, abs(pole) ** 2], rng.normal(size=n_samples + 2000)
        )
        modal.append(motion[2000:] / np.std(motion))
    acceleration = np.transpose(modal) @ shapes.T
    acceleration += 0.02 * np.std(acceleration) * rng.normal(size=acceleration.shape)
    return Frame(frequencies_hz, shapes, acceleration, sample_rate_hz)
