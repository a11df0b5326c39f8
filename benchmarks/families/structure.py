"""A random structure: modes anywhere in the band, pairs of them, damping that may couple them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.identifier.plant import Plant

LEAST_ZETA, MOST_ZETA = 2e-4, 0.2
"""What coupling may make of the damping ratios drawn."""


@dataclass(frozen=True)
class Modal:
    """Equations of motion in modal coordinates: q'' + D q' + Ω² q = B u, y = Φ q''.

    Parameters
    ----------
    omega : (n_modes,) array [rad/s]
        Natural frequencies without damping.
    damping : (n_modes, n_modes) array [rad/s]
        D, positive definite; diagonal: real shapes.
    shapes : (n_channels, n_modes) array
        Φ.
    forces : (n_modes, n_forces) array
        B.
    """

    omega: NDArray[np.float64]
    damping: NDArray[np.float64]
    shapes: NDArray[np.float64]
    forces: NDArray[np.float64]

    def plant(self) -> Plant | None:
        """Return poles, complex shapes and participation; None where a mode is overdamped."""
        n = len(self.omega)
        zero, one = np.zeros((n, n)), np.eye(n)
        state = np.block([[zero, one], [-np.diag(self.omega**2), -self.damping]])
        values, vectors = np.linalg.eig(state)
        left = np.linalg.inv(vectors)[:, n:]
        upper = np.flatnonzero(values.imag > 0.0)
        if len(upper) < n:
            return None
        upper = upper[np.argsort(np.abs(values[upper]))]
        size = np.abs(values[upper])
        zeta = -values[upper].real / size
        if zeta.min() < LEAST_ZETA or zeta.max() > MOST_ZETA:
            return None
        return Plant(
            size / (2.0 * np.pi),
            zeta,
            self.shapes @ vectors[:n, upper],
            left[upper] @ self.forces,
        )


def draw_frequencies(
    rng: np.random.Generator, n_modes: int, lowest_hz: float, highest_hz: float, pairs: float
) -> NDArray[np.float64]:
    """Draw log-uniform frequencies; a share of them are partners 0.3 to 10 % above another."""
    n_partners = int(rng.binomial(n_modes // 2, pairs)) if pairs else 0
    n_single = n_modes - n_partners
    single = np.exp(rng.uniform(np.log(lowest_hz), np.log(highest_hz), n_single))
    first = rng.choice(single, n_partners, replace=False)
    gap = np.exp(rng.uniform(np.log(0.003), np.log(0.1), n_partners))
    return np.sort(np.concatenate([single, first * (1.0 + gap)]))


def draw_damping(
    rng: np.random.Generator, omega: NDArray[np.float64], limits: tuple[float, float]
) -> NDArray[np.float64]:
    """Draw log-uniform damping ratios and return D without coupling."""
    zeta = np.exp(rng.uniform(np.log(limits[0]), np.log(limits[1]), len(omega)))
    return np.diag(2.0 * zeta * omega)


def coupled(
    rng: np.random.Generator, damping: NDArray[np.float64], share: float
) -> NDArray[np.float64]:
    """Couple the modes by a share of dampers in three places: 0: not at all, 1: only these."""
    reach = rng.standard_normal((len(damping), 3))
    reach /= np.linalg.norm(reach, axis=1, keepdims=True)
    alike = (1.0 - share) * np.eye(len(damping)) + share * reach @ reach.T
    size = np.sqrt(np.diag(damping))
    return np.asarray(size[:, None] * alike * size)


def draw_shapes(rng: np.random.Generator, n_channels: int, n_modes: int) -> NDArray[np.float64]:
    """Draw shapes: rough ones, or waves along a line of sensors, as on a beam or a tower."""
    rough = rng.standard_normal((n_channels, n_modes))
    if rng.random() < 0.5:
        return rough
    place = np.sort(rng.uniform(0.05, 1.0, n_channels))[:, None]
    number = rng.permutation(n_modes)[None, :] + 0.5
    phase = rng.uniform(0.0, 0.3 * np.pi, n_modes)
    return np.asarray(np.sin(np.pi * number * place + phase) + 0.15 * rough)
