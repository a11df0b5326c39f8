"""Records of a structure that a tool cuts on: random forces, and orders of a spindle.

A multiple of the spindle's speed lies 1 % above a mode.  Orders force the structure like
everything else does, so that they grow and turn where they cross a mode.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft, rfftfreq

from benchmarks.families.force import draw_spectrum
from benchmarks.families.record import Record
from benchmarks.families.response import (
    draw_force,
    in_time,
    modal_accelerations,
    period,
    power_around,
)
from benchmarks.families.structure import draw_damping, draw_shapes, Modal
from benchmarks.identifier.plant import Plant
from modal_core.channel import Channel
from modal_core.samples import Samples

RATE_HZ, DURATION_S = 256.0, 60.0
BAND_HZ, HIGHEST_ORDER_HZ = (8.0, 90.0), 100.0
DAMPING, N_MODES, N_CHANNELS, N_TEETH = (0.006, 0.03), (4, 8), (6, 13), (2, 5)
NEAR = 1.01
"""Frequency of an order over that of a mode, at the first speed."""
SPEEDS = (1.0, 1.07, 0.93)
SPINDLE_HZ = (6.0, 18.0)
LEVEL_DB, AROUND_HZ = (20.0, 40.0), 0.5
"""Power of an order over that of the response to random forces within so much to both sides."""
NOISE = 0.01
Real = NDArray[np.float64]


@dataclass(frozen=True)
class Cut:
    """What the spindle does.

    Parameters
    ----------
    speed : int
        Which of the three.
    ramp : float
        By how much the speed grows over the record, of its mean.
    waver : float
        Amplitude of its variation, of its mean, 3.3 times a record.
    turns : bool
        False: nothing is cut.
    """

    speed: int = 0
    ramp: float = 0.0
    waver: float = 0.0
    turns: bool = True


@dataclass(frozen=True)
class Milled:
    """A record with its truth, and what it would be without the orders."""

    truth: Record
    clean: Real
    cut: Cut

    @property
    def samples(self) -> Samples:
        """As a method takes it."""
        names = tuple(Channel(f'ch{number + 1}') for number in range(self.clean.shape[1]))
        return Samples(self.truth.acceleration, RATE_HZ, names)


def milled(seed: int, cut: Cut) -> Milled:
    """Draw the record of a seed; the structure is the same for all cuts."""
    rng = np.random.default_rng([seed, 77])
    plant, spindle_hz, orders = _structure(rng)
    spindle_hz *= SPEEDS[cut.speed]
    rng = np.random.default_rng([seed, cut.speed, int(1000 * cut.ramp), int(1000 * cut.waver)])
    n_samples, n_modes = int(RATE_HZ * DURATION_S), len(plant.frequency_hz)
    n_period = period(plant, n_samples, RATE_HZ)
    white = draw_spectrum(rng, 'white', *BAND_HZ)
    force = draw_force(rng, n_modes, n_period, RATE_HZ, white, np.ones(n_samples))
    random = replace(plant, participation=plant.participation[:, :n_modes])
    machine = replace(plant, participation=plant.participation[:, n_modes:])
    each = list(_each_mode(random, force, n_samples))
    clean = np.sum([response for response, _ in each], axis=0)
    variance = clean.var(axis=0)
    noise_std = NOISE * np.sqrt(variance)
    clean = clean + noise_std * rng.standard_normal(clean.shape)
    share = (np.arange(n_period) - (n_period - n_samples)) / n_samples
    speed = 1.0 + cut.ramp * np.clip(share - 0.5, -0.5, 0.5)
    speed += cut.waver * np.sin(2.0 * np.pi * 3.3 * share)
    phase = 2.0 * np.pi * spindle_hz / RATE_HZ * np.cumsum(speed)
    # It starts a while before the record, so that the period begins and ends in rest.
    start = np.clip(3.0 * (1.0 + share * n_samples / (n_period - n_samples)), 0.0, 1.0)
    dirty, lines_hz = clean.copy(), []
    for order in orders if cut.turns else ():
        order_hz = order * spindle_hz
        if order_hz * (1.0 + 0.5 * cut.ramp + cut.waver) > HIGHEST_ORDER_HZ:
            continue
        tone = np.cos(order * phase + rng.uniform(0.0, 2.0 * np.pi)) * start
        answer = np.sum([one for one, _ in _each_mode(machine, tone[:, None], n_samples)], axis=0)
        wanted = _power(clean, order_hz, AROUND_HZ) * 10.0 ** (0.1 * rng.uniform(*LEVEL_DB))
        dirty += answer * np.sqrt(wanted / np.sum(np.mean(answer**2, axis=0)))
        lines_hz.append(order_hz)
    truth = Record(
        family='milling',
        seed=seed,
        plant=random,
        acceleration=dirty,
        rate_hz=RATE_HZ,
        share=np.array([np.mean(own / variance) for _, own in each]),
        lines_hz=tuple(lines_hz),
        drift=0.0,
        noise=NOISE,
        noise_std=noise_std,
        n_forces=n_modes,
        forces='white steady',
        gain=np.ones(n_modes),
        steady=1.0,
    )
    return Milled(truth, clean, cut)


def _structure(rng: np.random.Generator) -> tuple[Plant, float, tuple[int, ...]]:
    """Return a plant whose last force is the tool's, the spindle's speed [Hz] and its orders."""
    n_modes = int(rng.integers(*N_MODES))
    place = (np.arange(n_modes) + rng.uniform(0.15, 0.85, n_modes)) / n_modes
    hz = BAND_HZ[0] * (BAND_HZ[1] / BAND_HZ[0]) ** place
    omega = 2.0 * np.pi * hz
    damping = draw_damping(rng, omega, DAMPING)
    shapes = draw_shapes(rng, int(rng.integers(*N_CHANNELS)), n_modes)
    forces = rng.standard_normal((n_modes, n_modes + 1)) * (hz[:, None] / hz[0]) ** -0.4
    plant = Modal(omega, damping, shapes, forces).plant()
    if plant is None:
        raise ValueError('overdamped, which light damping without coupling cannot be')
    teeth, wanted_hz = int(rng.integers(*N_TEETH)), NEAR * float(rng.choice(hz))
    lowest = int(np.ceil(wanted_hz / SPINDLE_HZ[1]))
    order = int(rng.integers(lowest, max(lowest, int(wanted_hz / SPINDLE_HZ[0])) + 1))
    return plant, wanted_hz / order, tuple(sorted({1, teeth, 2 * teeth, 3 * teeth, order}))


def _each_mode(plant: Plant, force: Real, n_samples: int) -> Iterator[tuple[Real, Real]]:
    """Yield what each mode does in the channels, and its variance around its own frequency."""
    for index, spectrum in enumerate(modal_accelerations(plant, force, RATE_HZ, 0.5)):
        shape = plant.shapes[:, index]
        own = 2.0 * power_around(spectrum, plant, index, RATE_HZ, n_samples)
        response = 2.0 * np.real(np.outer(in_time(spectrum, n_samples), shape))
        yield response, own * np.abs(shape) ** 2


def _power(rows: Real, hz: float, around_hz: float) -> float:
    """Return the mean power within a distance of a frequency, a sum over the channels."""
    taper = np.hanning(len(rows))
    spectrum = np.abs(rfft(rows * taper[:, None], axis=0)) ** 2
    near = np.abs(rfftfreq(len(rows), 1.0 / RATE_HZ) - hz) < around_hz
    return float(2.0 * spectrum[near].sum() / (len(rows) * np.sum(taper**2)))


def excess_db(record: Milled, left: Samples) -> list[float]:
    """Return what is left over the response to random forces, where each order moved [dB]."""
    moved = 0.5 * record.cut.ramp + record.cut.waver
    excess = []
    for hz in record.truth.lines_hz:
        around = max(AROUND_HZ, 1.1 * moved * hz)
        ratio = _power(left.widened(), hz, around) / _power(record.clean, hz, around)
        excess.append(float(10.0 * np.log10(ratio)))
    return excess
