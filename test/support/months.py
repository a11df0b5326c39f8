"""A month of a robot: a planar arm on three springs that works in poses, warms up and is loaded.

Frequencies are those of ``K φ = ω² M(q, load) φ``; stiffness follows temperature with delay.
"""

from dataclasses import dataclass

import numpy as np

from modal_core.mode import Mode, ModeSet
from modal_core.window import Pose
from modal_history.kept import KeptWindow
from modal_history.trend import Trend

MINUTE_NS, START_NS = 60 * 10**9, 1_780_000_000 * 10**9
DAY = 24 * 60
LINK_M, MASS_KG, ARM_KG = (1.0, 0.8, 0.4), (60.0, 30.0, 10.0), 6.0
STIFFNESS = np.array([9e5, 3e5, 4e4])


@dataclass(frozen=True)
class Month:
    """What a month is like.

    Parameters
    ----------
    n_days, seed : int
        Its length, one result a minute; its randomness.
    std : float
        Relative deviation of one result, as stated.
    wander : float
        Relative deviation of what nobody measures, with a memory of four hours.
    lost : sequence of float
        Share of stiffness that each joint loses at ``at_day``.
    at_day : float
        When.
    free : bool
        Poses from anywhere, in place of twelve that are come back to.
    outliers : float
        Share of results that are wrong by ten deviations.
    knows_temperature : bool
        Whether a topic gives it.
    """

    n_days: int
    seed: int
    std: float = 1.5e-3
    wander: float = 5e-4
    lost: tuple[float, ...] = (0.0, 0.0, 0.0)
    at_day: float = np.inf
    free: bool = False
    outliers: float = 0.002
    knows_temperature: bool = True

    def trends(self):
        """Return the trends of the three modes."""
        rng, n = np.random.default_rng(self.seed), self.n_days * DAY
        day = np.arange(n) / DAY
        air = 22 + 5 * np.sin(2 * np.pi * (day - 0.3)) + slow(rng, n, 2 * DAY) * 2
        air += 2.0 * (np.floor(day) % 7 > 4)
        warm = np.array(air)
        for row in range(1, n):
            warm[row] = warm[row - 1] + (air[row] - warm[row - 1]) / 90.0
        q = poses(rng, n, self.free)
        load = rng.choice([0.0, 12.0, 20.0], size=n // 30 + 1).repeat(30)[:n]
        left = 1.0 - np.outer(day >= self.at_day, self.lost) - 1e-3 * (warm[:, None] - 22.0)
        truth = frequencies(q, load, STIFFNESS * left)
        found = []
        for number, column in enumerate(truth.T):
            share = self.std * rng.normal(size=n) + self.wander * slow(rng, n, 240.0)
            share += 10 * self.std * rng.normal(size=n) * (rng.random(n) < self.outliers)
            there = rng.random(n) < 0.95
            found.append(self._trend(number + 1, column * (1 + share), air, load, q, there, rng))
        return found

    def _trend(self, number, frequency_hz, air, load, q, there, rng):
        n = len(air)
        start = START_NS + np.arange(n) * MINUTE_NS
        stated = self.std * frequency_hz * np.exp(0.1 * rng.normal(size=n))
        temperature = air + 0.2 * rng.normal(size=n) if self.knows_temperature else air * np.nan
        whole = Trend(
            id=number, time_ns=start + MINUTE_NS, start_ns=start, frequency_hz=frequency_hz,
            frequency_std_hz=stated, damping_ratio=np.full(n, 0.01),
            damping_ratio_std=np.full(n, 1e-3), temperature_c=temperature, load_kg=load,
            position=q,
        )  # fmt: skip
        return whole.rows(np.flatnonzero(there))


def slow(rng, n, memory):
    """Return a process with deviation 1 that forgets in so many minutes."""
    stays = np.exp(-1.0 / memory)
    noise, found = rng.normal(size=n) * np.sqrt(1 - stays**2), np.empty(n)
    found[0] = rng.normal()
    for row in range(1, n):
        found[row] = stays * found[row - 1] + noise[row]
    return found


def poses(rng, n, free):
    if free:
        return np.column_stack([rng.uniform(-1.0, 1.0, n) for _ in range(3)])
    known = rng.uniform(-1.2, 1.2, size=(12, 3))
    return known[rng.integers(12, size=n)] + 0.005 * rng.normal(size=(n, 3))


def frequencies(q, load, stiffness):
    """Return natural frequencies [Hz], (n, 3), and of each the joints' shares are its shape's."""
    angle = np.cumsum(q, axis=1)
    steps = np.array(LINK_M)[None, :, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=2)
    joints = np.concatenate([np.zeros((len(q), 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    inertia = np.zeros((len(q), 3, 3))
    for body in range(3):
        arms = np.where(
            (np.arange(3) <= body)[None, :, None], joints[:, body + 1, None] - joints[:, :3], 0.0
        )
        mass = MASS_KG[body] + (load if body == 2 else 0.0)
        inertia += np.einsum('nij,nkj->nik', arms, arms) * np.reshape(mass, (-1, 1, 1))
        inertia[:, : body + 1, : body + 1] += ARM_KG * LINK_M[body] ** 2
    root = np.sqrt(stiffness)
    # K = diag: eigenvalues of K^(1/2) M^-1 K^(1/2).
    both = root[:, :, None] * np.linalg.inv(inertia) * root[:, None, :]
    return np.sqrt(np.linalg.eigvalsh(both)) / (2 * np.pi)


def windows_of(trends, since_ns, joints=('j1', 'j2', 'j3')):
    """Return the results since a time as windows, without shapes."""
    rows = {}
    for trend in trends:
        for row in np.flatnonzero(trend.start_ns >= since_ns):
            rows.setdefault(int(trend.time_ns[row]), []).append((trend, row))
    return [
        _window(n, time_ns, found, joints)
        for n, (time_ns, found) in enumerate(sorted(rows.items()))
    ]


def _window(number, time_ns, found, joints):
    trend, row = found[0]
    modes = tuple(
        Mode(
            frequency_hz=float(each.frequency_hz[at]),
            damping_ratio=0.01,
            shape=np.ones(1, dtype=complex),
            frequency_std_hz=float(each.frequency_std_hz[at]),
            id=each.id,
        )
        for each, at in found
    )
    return KeptWindow(
        index=number,
        start_ns=time_ns - MINUTE_NS,
        end_ns=time_ns,
        modes=ModeSet(modes, ('s1.x',)),
        pose=Pose(joints, trend.position[row], np.zeros(len(joints))),
        load_kg=float(trend.load_kg[row]),
    )
