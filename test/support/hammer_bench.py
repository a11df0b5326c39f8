"""Taps on a chain of masses, simulated step by step: exact, and by no formula of the fit's."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, expm
from scipy.signal import dlsim, firwin

from impact_testing import ImpactRecord
from modal_core.channel import Channel
from modal_core.samples import Samples

FINER = 8


@dataclass(frozen=True)
class Structure:
    """M x'' + C x' + K x = f."""

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray

    @property
    def n(self):
        return len(self.M)

    def modes(self):
        """Return poles and shapes with φᵀ(2pM + C)φ = 1, by frequency."""
        zero, one = np.zeros_like(self.M), np.eye(self.n)
        first = np.block([[zero, one], [-np.linalg.solve(self.M, np.hstack([self.K, self.C]))]])
        poles, vectors = eig(first)
        keep = np.flatnonzero(poles.imag > 0)
        keep = keep[np.argsort(np.abs(poles[keep]))]
        poles, shapes = poles[keep], vectors[: self.n, keep]
        scale = [v @ (2 * p * self.M + self.C) @ v for p, v in zip(poles, shapes.T, strict=True)]
        return poles, shapes / np.sqrt(np.array(scale))

    def frf(self, frequency_hz):
        """Return accelerances, (n_lines, n, n)."""
        s = 2j * np.pi * np.asarray(frequency_hz)[:, None, None]
        return s**2 * np.linalg.inv(s**2 * self.M + s * self.C + self.K)


def bench():
    """Return the three masses of the reference, modal damping 2, 1.5 and 3 %."""
    M = np.diag([10.0, 8.0, 6.0])
    K = 1e3 * np.array([[60.0, -30, 0], [-30, 50, -20], [0, -20, 20]])
    C = np.array(
        [[33.2191, -17.744, 3.881], [-17.744, 31.208, -9.0695], [3.881, -9.0695, 11.9773]]
    )
    return Structure(M, C, K)


def random_structure(rng, n=5, damping=(0.007, 0.04)):
    """Return a chain with every mass on the ground, 8 to 60 Hz, damped as given."""
    mass = rng.uniform(4.0, 12.0, n)
    K = np.zeros((n, n))
    for i in range(n):
        for j in range(i):
            k = 10 ** rng.uniform(3.5, 4.8) if i - j == 1 else 10 ** rng.uniform(2, 3.8)
            K[[i, j], [i, j]] += k
            K[i, j] -= k
            K[j, i] -= k
        K[i, i] += 10 ** rng.uniform(4.0, 5.5)
    M = np.diag(mass)
    lower = np.linalg.cholesky(M)
    squared, q = np.linalg.eigh(np.linalg.solve(lower, np.linalg.solve(lower, K).T))
    phi = np.linalg.solve(lower.T, q)
    zeta = rng.uniform(*damping, n)
    C = M @ phi @ np.diag(2 * zeta * np.sqrt(squared)) @ phi.T @ M
    return Structure(M, C, K)


def even_chain(n=5, mass=10.0, stiffness=4e5, damping=0.01):
    """Return equal masses between equal springs, one end on the ground.

    f_r = √(k/m) / π · sin((2r - 1) π / (4n + 2)); every shape has the entries sin(jπ / (2n + 1)),
    j = 1..n, in another order, so that all modal masses are m (2n + 1) / 4 / cos²(π / (4n + 2)).
    """
    K = stiffness * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    K[-1, -1] = stiffness
    squared, q = np.linalg.eigh(K / mass)
    C = mass * q @ np.diag(2.0 * damping * np.sqrt(squared)) @ q.T
    return Structure(mass * np.eye(n), C, K)


def half_sine(width_s, rate_hz):
    t = np.arange(round(width_s * rate_hz) + 1) / rate_hz
    return np.sin(np.pi * t / width_s)


def taps(
    structure,
    hit,
    times_s,
    rng,
    rate_hz=512.0,
    last_s=4.0,
    width_s=0.006,
    noise=0.0,
    force_noise_n=0.0,
    second=(),
    name='',
    names=None,
):
    """Return a record of taps at mass ``hit``, all masses measured.

    ``noise`` is the standard deviation of each response's noise [m/s²]; ``second`` (number of the
    tap, delay [s], share) adds second hits.
    """
    fine = rate_hz * FINER
    n = round((times_s[-1] + last_s) * fine)
    force = np.zeros(n)
    hits = [(time, rng.uniform(80.0, 160.0)) for time in times_s]
    hits += [(times_s[k] + delay, share * hits[k][1]) for k, delay, share in second]
    for time, size in hits:
        pulse = size * half_sine(width_s * rng.uniform(0.9, 1.1), fine)
        first = round(time * fine)
        force[first : first + len(pulse)] += pulse
    zero, one = np.zeros_like(structure.M), np.eye(structure.n)
    A = np.block(
        [[zero, one], [-np.linalg.solve(structure.M, np.hstack([structure.K, structure.C]))]]
    )
    B = np.concatenate([np.zeros(structure.n), np.linalg.inv(structure.M)[:, hit]])[:, None]
    # Force linear between the fine samples: exact for that force.
    big = np.zeros((2 * structure.n + 2,) * 2)
    big[: 2 * structure.n, : 2 * structure.n] = A / fine
    big[: 2 * structure.n, [2 * structure.n]] = B / fine
    big[2 * structure.n, 2 * structure.n + 1] = 1.0
    step = expm(big)
    Phi = step[: 2 * structure.n, : 2 * structure.n]
    G1 = step[: 2 * structure.n, [2 * structure.n]]
    G2 = step[: 2 * structure.n, [2 * structure.n + 1]]
    # x[k+1] = Phi x + (G1 - G2) f[k] + G2 f[k+1]; z = x - G2 f.
    Bd = Phi @ G2 + G1 - G2
    C, D = A[structure.n :], B[structure.n :]
    _, motion, _ = dlsim((Phi, Bd, C, C @ G2 + D, 1.0 / fine), force[:, None])
    # The same filter before both converters.
    taps_of_filter = firwin(40 * FINER + 1, 0.42 * rate_hz, fs=fine)
    half = len(taps_of_filter) // 2
    both = np.column_stack([force, motion])
    both = np.apply_along_axis(lambda c: np.convolve(c, taps_of_filter)[half : half + n], 0, both)
    both = both[::FINER]
    force, motion = both[:, 0], both[:, 1:]
    motion = motion + noise * rng.standard_normal(motion.shape)
    force = force + force_noise_n * rng.standard_normal(force.shape)
    names = names or [f'm{i + 1}' for i in range(structure.n)]
    samples = Samples(motion, rate_hz, tuple(Channel(each) for each in names))
    return ImpactRecord(force, samples, names[hit], name or f'taps on {names[hit]}')
