"""Modes that move with a joint's speed, and lines that move with a spindle's.

`python -m benchmarks.methods.moving`, some minutes of processor time.  Nobody tunes on
these seeds.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
import warnings

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter, resample_poly

from benchmarks.families.judge import judge
from benchmarks.methods.milled import Cut, DURATION_S, excess_db, milled
from benchmarks.results import write_rows
from modal_core.channel import Channel
from modal_core.mode import ModeSet
from modal_core.samples import Samples
from modal_core.spindle_speed import SpindleSpeed
from oma_identifier.methods import identify_by
from oma_identifier.motion import never
from oma_identifier.moving_lines import without_moving
from oma_identifier.settings import IdentificationSettings
from oma_identifier.window_finder import WindowFinder

FIRST_SEED = 793_000
N_RECORDS, N_MILLED = 6, 4
RATE_HZ, RECORD_S, WINDOW_S, HOP_S = 128.0, 240.0, 20.0, 10.0
OVERSAMPLED, HELD = 8, 64
"""Steps of the simulation per sample, and steps over which the stiffness stays."""
SOFTER, NOISE, NEAR = 0.2, 0.03, 0.05
METHODS = ('rvar', 'ssi_cov')
TACHOMETER_HZ, TACHOMETER_NOISE, TURNS_HZ = 10.0, 1e-3, 13.0
LEFT_DB = 3.0
COLUMNS = (
    'records',
    'method',
    'modes found',
    'false modes',
    '2σ of f',
    '2σ of ζ',
    'rms error of f, %',
    'orders left above 3 dB',
)
Real = NDArray[np.float64]


@dataclass(frozen=True)
class Softening:
    """A chain of masses whose springs soften while a joint runs faster."""

    mass: Real
    spring: Real
    damping: Real

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> 'Softening':
        """Draw three or four masses, modes damped by 1 to 3 %."""
        n = int(rng.integers(3, 5))
        mass = rng.uniform(0.5, 1.5, n)
        spring = rng.uniform(0.6, 1.6, n) * (2.0 * np.pi * rng.uniform(14.0, 20.0)) ** 2
        root = np.sqrt(mass)
        square, turned = np.linalg.eigh(_stiffness(spring) / np.outer(root, root))
        each = 2.0 * rng.uniform(0.01, 0.03, n) * np.sqrt(square)
        damping = np.outer(root, root) * (turned * each @ turned.T)
        return cls(mass, spring, damping)

    def system(self, speed: float) -> Real:
        """Return the matrix of the equations of first order at a share of the highest speed."""
        n = len(self.mass)
        stiffness = (1.0 - SOFTER * speed) * _stiffness(self.spring)
        top = np.hstack([np.zeros((n, n)), np.eye(n)])
        return np.vstack([top, -np.hstack([stiffness, self.damping]) / self.mass[:, None]])

    def poles(self, speed: float) -> NDArray[np.complex128]:
        """Return the poles at a speed, by frequency [rad/s]."""
        poles = np.linalg.eigvals(self.system(speed))
        poles = poles[poles.imag > 0.0]
        return np.asarray(poles[np.argsort(np.abs(poles))])


def _stiffness(spring: Real) -> Real:
    return (
        np.diag(spring + np.append(spring[1:], 0.0))
        - np.diag(spring[1:], 1)
        - np.diag(spring[1:], -1)
    )


def speed_at(share: float) -> float:
    """Return the joint's speed over its highest: from rest and back, as a raised cosine."""
    return float(np.sin(np.pi * share) ** 2)


def record_of(arm: Softening, rng: np.random.Generator) -> Samples:
    """Return accelerations under white forces on all masses while the speed runs its course."""
    n, n_steps = len(arm.mass), int(RECORD_S * RATE_HZ) * OVERSAMPLED
    step_s = 1.0 / (RATE_HZ * OVERSAMPLED)
    force = rng.standard_normal((n_steps, n)) / arm.mass
    answer, state = np.empty((n_steps, n)), np.zeros(2 * n, dtype=complex)
    for first in range(0, n_steps, HELD):
        system = arm.system(speed_at((first + 0.5 * HELD) / n_steps))
        poles, shapes = np.linalg.eig(system)
        turn, part = np.exp(poles * step_s), force[first : first + HELD]
        into = np.linalg.inv(shapes)
        driven = part @ into[:, n:].T * ((turn - 1.0) / poles)
        start, course = into @ state, np.empty((len(part) + 1, 2 * n), dtype=complex)
        course[0] = start
        for mode in range(2 * n):
            begin = [turn[mode] * start[mode]]
            course[1:, mode] = lfilter([1.0], [1.0, -turn[mode]], driven[:, mode], zi=begin)[0]
        states = course @ shapes.T
        answer[first : first + HELD] = (states[:-1] @ system[n:].T).real + part
        state = states[-1]
    rows = resample_poly(answer, 1, OVERSAMPLED, axis=0)
    rows += NOISE * rows.std(axis=0) * rng.standard_normal(rows.shape)
    return Samples(rows, RATE_HZ, tuple(Channel(f'm{number + 1}') for number in range(n)))


@dataclass
class Count:
    """What windows say of the modes at their own moment."""

    n_asked: int = 0
    n_found: int = 0
    n_false: int = 0
    frequency: list[tuple[float, float]] = field(default_factory=list)
    damping: list[tuple[float, float]] = field(default_factory=list)

    def add(self, modes: ModeSet, poles: NDArray[np.complex128]) -> None:
        """Hold the modes of a window against the truth in its middle."""
        used: set[int] = set()
        for pole in poles:
            hz, ratio = np.abs(pole) / (2.0 * np.pi), -pole.real / np.abs(pole)
            self.n_asked += 1
            off = np.abs(modes.frequency_hz / hz - 1.0) if len(modes) else np.ones(1)
            nearest = int(np.argmin(off))
            if off[nearest] > NEAR or nearest in used:
                continue
            used.add(nearest)
            mode = modes.modes[nearest]
            self.frequency.append((mode.frequency_hz / hz - 1.0, mode.frequency_std_hz / hz))
            self.damping.append((mode.damping_ratio - ratio, mode.damping_ratio_std))
        self.n_found += len(used)
        self.n_false += len(modes) - len(used)

    def row(self, what: str, method: str, left: str) -> list[str]:
        """Return the line of the table."""
        rms = 100.0 * np.sqrt(np.mean(np.square([error for error, _ in self.frequency])))
        return [
            what,
            method,
            f'{self.n_found} of {self.n_asked}',
            str(self.n_false),
            _within(self.frequency),
            _within(self.damping),
            f'{rms:.2f}',
            left,
        ]


def _within(errors: list[tuple[float, float]]) -> str:
    known = [(error, std) for error, std in errors if np.isfinite(std)]
    inside = sum(abs(error) < 2.0 * std for error, std in known)
    return f'{100.0 * inside / len(known):.0f} % of {len(known)}' if known else '-'


def followed(method: str) -> Count:
    """Return what windows find of records in which the speed runs its course."""
    count = Count()
    settings = IdentificationSettings(
        method=method, window_s=WINDOW_S, hop_s=HOP_S, min_frequency_hz=2.0
    )
    for seed in range(FIRST_SEED, FIRST_SEED + N_RECORDS):
        rng = np.random.default_rng(seed)
        arm = Softening.drawn(rng)
        samples, finder = record_of(arm, rng), WindowFinder(settings)
        for first in range(0, int((RECORD_S - WINDOW_S) / HOP_S) + 1):
            rows = slice(int(first * HOP_S * RATE_HZ), int((first * HOP_S + WINDOW_S) * RATE_HZ))
            middle = (first * HOP_S + 0.5 * WINDOW_S) / RECORD_S
            found = finder.find(samples.part(rows), never).modes
            count.add(found, arm.poles(speed_at(middle)))
    return count


def tachometer(cut: Cut, seed: int) -> SpindleSpeed:
    """Return the measured speed of a cut: values off by noise."""
    share = np.linspace(0.0, 1.0, int(TACHOMETER_HZ * DURATION_S) + 1)
    speed = 1.0 + cut.ramp * (share - 0.5)
    speed *= 1.0 + TACHOMETER_NOISE * np.random.default_rng(seed).standard_normal(len(share))
    return SpindleSpeed.of(np.round(1e9 * DURATION_S * share).astype(np.int64), TURNS_HZ * speed)


def milling(*, measured: bool) -> tuple[Count, str]:
    """Return what the default method finds while the spindle speeds up, and the orders left."""
    count, n_orders, n_left = Count(), 0, 0
    for seed in range(FIRST_SEED, FIRST_SEED + N_MILLED):
        cut = Cut(speed=seed % 3, ramp=0.1)
        record = milled(seed, cut)
        samples = record.samples
        if measured:
            samples = replace(samples, speed=tachometer(cut, seed))
        excess = excess_db(record, without_moving(samples)[0])
        n_orders, n_left = n_orders + len(excess), n_left + sum(e > LEFT_DB for e in excess)
        found = identify_by('ssi_cov', samples)
        plant = record.truth.plant
        omega = 2.0 * np.pi * plant.frequency_hz
        poles = omega * (-plant.damping_ratio + 1j * np.sqrt(1.0 - plant.damping_ratio**2))
        n_false = judge(found.modes.modes, found.harmonics.modes, record.truth).n_false
        before = count.n_false
        count.add(found.modes, poles)
        count.n_false = before + int(n_false)
    return count, f'{n_left} of {n_orders}'


def rows() -> Iterator[list[str]]:
    """Yield the lines of the table."""
    what = (
        f'stiffness falls by 20 % with the speed of a joint, {N_RECORDS} structures,'
        f' windows of {WINDOW_S:g} s'
    )
    for method in METHODS:
        yield followed(method).row(what, method, '-')
    what = f'spindle speed grows by 10 % in 60 s, {N_MILLED} structures'
    for measured, name in ((False, 'ssi_cov, speed found'), (True, 'ssi_cov, speed measured')):
        count, left = milling(measured=measured)
        yield count.row(what, name, left)


def main() -> None:
    """Measure, print and keep the table."""
    warnings.simplefilter('ignore')
    found = []
    print(' | '.join(COLUMNS))
    for line in rows():
        found.append(line)
        print(' | '.join(line), flush=True)
    write_rows('moving', COLUMNS, found)


if __name__ == '__main__':
    main()
