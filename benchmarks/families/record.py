"""One record of a family: drawn by its seed alone, with all that is true about it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
import zlib

import numpy as np
from numpy.typing import NDArray

from benchmarks.families.bound import bound, local_bound
from benchmarks.families.family import Family, Range, STEADY, WHITE
from benchmarks.families.force import draw_envelope, draw_spectrum
from benchmarks.families.response import (
    anti_alias,
    draw_force,
    in_time,
    modal_accelerations,
    period,
    poles,
)
from benchmarks.families.structure import (
    coupled,
    draw_damping,
    draw_frequencies,
    draw_shapes,
    Modal,
)
from benchmarks.plant import Plant
from benchmarks.scatter import law

MOST_SAMPLES, MOST_VALUES, MOST_DRIFTING = 250_000, 2_500_000, 50_000
"""Samples, samples x channels, and samples where frequencies drift: a record takes seconds."""
FEWEST_SAMPLES = 1000
HIGHEST = 0.4
"""Highest natural frequency over the sample rate."""
AROUND = 3.0
"""Half-widths to either side of a mode in which its response counts as its own."""


@dataclass(frozen=True)
class Record:
    """Responses and the truth.

    Parameters
    ----------
    family, seed : str, int
        They determine the rest.
    plant : Plant
        Poles, complex shapes and participation; the mean where frequencies drift.
    acceleration : (n_samples, n_channels) array
        With noise.
    rate_hz : float [Hz]
    share : (n_modes,) array
        Variance of the response within three half-widths of a mode that is its own, over the
        variance of the response without noise, a mean over the channels.
    lines_hz : tuple of float [Hz]
    drift : float
        From least to greatest natural frequency over the mean.
    noise : float
        Over the standard deviation of the responses.
    noise_std : (n_channels,) array [m/s²]
    n_forces : int
    forces : str
        Kind of forces.
    gain : (n_modes,) array
        Of the spectrum of the forces at the modes.
    steady : float
        Share of the record in which steady forces would tell as much: (mean power)² over the mean
        of its square.
    """

    family: str
    seed: int
    plant: Plant
    acceleration: NDArray[np.float64]
    rate_hz: float
    share: NDArray[np.float64]
    lines_hz: tuple[float, ...]
    drift: float
    noise: float
    noise_std: NDArray[np.float64]
    n_forces: int
    forces: str
    gain: NDArray[np.float64]
    steady: float

    @property
    def duration_s(self) -> float:
        """Samples over rate [s]."""
        return len(self.acceleration) / self.rate_hz

    @property
    def steady_s(self) -> float:
        """Length of a record under steady forces that would tell as much [s]."""
        return self.steady * self.duration_s

    @cached_property
    def law(self) -> NDArray[np.float64]:
        """Least relative deviations of f and ζ were a mode alone (Au 2014), (2, n_modes)."""
        return law(self.plant, self.steady_s)

    @cached_property
    def bound(self) -> NDArray[np.float64] | None:
        """The Cramér-Rao bound of the same; None where its model is not that of the record."""
        if self.forces != f'{WHITE} {STEADY}' or self.lines_hz or self.drift:
            return None
        return bound(self.plant, self.noise_std, self.rate_hz, self.duration_s)

    @cached_property
    def deviation(self) -> NDArray[np.float64]:
        """The larger of law and bound, or of what the bound is at least, (2, n_modes)."""
        least = self.bound
        if least is None:
            forced = self.plant.participation * self.gain[:, None]
            plant = replace(self.plant, participation=forced)
            least = local_bound(plant, self.noise_std, self.rate_hz, self.steady_s)
        return np.maximum(self.law, least)

    def __str__(self) -> str:
        """Describe it in one line."""
        n_samples, n_channels = self.acceleration.shape
        zeta = 100.0 * self.plant.damping_ratio
        return (
            f'{self.family} {self.seed}: {n_channels} channels, {self.rate_hz:.4g} Hz,'
            f' {n_samples / self.rate_hz:.4g} s, {len(zeta)} modes, ζ {zeta.min():.2g} to'
            f' {zeta.max():.2g} %, noise {self.noise:.2g}, {self.n_forces} forces {self.forces},'
            f' lines {np.round(self.lines_hz, 3).tolist()}, drift {self.drift:.2g}'
        )


def draw(family: Family, seed: int) -> Record:
    """Draw the record of a seed."""
    rng = np.random.default_rng([seed, zlib.crc32(family.name.encode())])
    rate_hz, n_samples, n_channels = _grid(rng, family)
    highest_hz = HIGHEST * rate_hz
    lowest_hz = max(rate_hz * 10.0 ** -rng.uniform(1.3, 2.5), 10.0 * rate_hz / n_samples)
    n_modes = _whole(rng, family.n_modes)
    frequency = draw_frequencies(rng, n_modes, lowest_hz, highest_hz, family.pairs)
    n_forces = max(1, round(rng.uniform(*family.rank) * n_modes))
    n_lines = int(rng.integers(family.n_lines[0], family.n_lines[1] + 1))
    plant = _plant(rng, family, frequency, n_channels, n_forces + n_lines)
    kind, course = str(rng.choice(family.forces)), str(rng.choice(family.courses))
    spectrum = draw_spectrum(rng, kind, lowest_hz, highest_hz)
    envelope = draw_envelope(rng, course, n_samples)
    edge = float(rng.choice([0.5, rng.uniform(0.42, 0.48)]))
    drift, own_time = _drift(rng, family.drift, n_samples)
    own = Plant(*_parts(plant, slice(0, n_forces)))
    force = draw_force(
        rng, n_forces, period(plant, n_samples, rate_hz), rate_hz, spectrum, envelope
    )
    clean = np.zeros((n_samples, n_channels))
    around = np.zeros((n_modes, n_channels))
    for mode, modal in enumerate(modal_accelerations(own, force, rate_hz, edge)):
        shape = own.shapes[:, mode]
        clean += 2.0 * np.real(np.outer(in_time(modal, n_samples, own_time), shape))
        around[mode] = (
            2.0 * np.abs(shape) ** 2 * _power_around(modal, own, mode, rate_hz, n_samples)
        )
    variance = clean.var(axis=0)
    lines = list(_lines(rng, plant, n_forces, rate_hz, edge, (lowest_hz, highest_hz), variance))
    time = np.arange(n_samples) / rate_hz
    for hz, amplitude in lines:
        clean += np.real(np.outer(np.exp(2j * np.pi * hz * time), amplitude))
    noise = _log(rng, family.noise)
    own_level = np.sqrt(variance)
    level = noise * (own_level if rng.random() < 0.5 else np.full(n_channels, own_level.mean()))
    scale = 10.0 ** rng.uniform(-2.0, 1.0) / own_level.mean()
    return Record(
        family=family.name,
        seed=seed,
        plant=replace(own, participation=scale * own.participation),
        acceleration=scale * (clean + level * rng.standard_normal(clean.shape)),
        rate_hz=rate_hz,
        share=np.mean(around / variance, axis=1),
        lines_hz=tuple(hz for hz, _ in lines),
        drift=drift,
        noise=noise,
        noise_std=scale * level,
        n_forces=n_forces,
        forces=f'{kind} {course}',
        gain=spectrum(own.frequency_hz),
        steady=float(np.mean(envelope**2) ** 2 / np.mean(envelope**4)),
    )


def _grid(rng: np.random.Generator, family: Family) -> tuple[float, int, int]:
    rate_hz = float(f'{_log(rng, family.rate_hz):.3g}')
    n_channels = _whole(rng, family.n_channels)
    most = min(MOST_SAMPLES, MOST_VALUES // n_channels)
    if family.drift[1] > 0.0:
        most = min(most, MOST_DRIFTING)
    n_samples = int(_log(rng, family.duration_s) * rate_hz)
    return rate_hz, min(most, max(FEWEST_SAMPLES, n_samples)), n_channels


def _log(rng: np.random.Generator, limits: Range) -> float:
    return float(np.exp(rng.uniform(*np.log(limits))))


def _whole(rng: np.random.Generator, limits: tuple[int, int]) -> int:
    return int(np.exp(rng.uniform(np.log(limits[0]), np.log(limits[1] + 1))))


def _plant(
    rng: np.random.Generator,
    family: Family,
    frequency_hz: NDArray[np.float64],
    n_channels: int,
    n_forces: int,
) -> Plant:
    """Draw the plant; one with an overdamped mode is coupled half as much."""
    omega = 2.0 * np.pi * frequency_hz
    damping = draw_damping(rng, omega, family.damping)
    shapes = draw_shapes(rng, n_channels, len(omega))
    forces = rng.standard_normal((len(omega), n_forces))
    # Forces that are equal over frequency let high modes swamp the low ones.
    forces *= (frequency_hz[:, None] / frequency_hz[0]) ** -0.4
    forces *= np.exp(0.5 * rng.standard_normal((len(omega), 1)))
    share = float(rng.uniform(*family.coupling))
    while True:
        plant = Modal(omega, coupled(rng, damping, share), shapes, forces).plant()
        if plant is not None:
            return plant
        share = 0.5 * share if share > 0.01 else 0.0


def _parts(
    plant: Plant, forces: slice
) -> tuple[
    NDArray[np.float64], NDArray[np.float64], NDArray[np.complex128], NDArray[np.complex128]
]:
    return (
        plant.frequency_hz,
        plant.damping_ratio,
        np.asarray(plant.shapes, dtype=complex),
        np.asarray(plant.participation[:, forces], dtype=complex),
    )


def _drift(
    rng: np.random.Generator, limits: Range, n_samples: int
) -> tuple[float, NDArray[np.float64] | None]:
    """Return the extent of a drift and the modes' own time [samples]."""
    extent = max(0.0, float(rng.uniform(*limits)))
    if not extent:
        return 0.0, None
    share = np.arange(n_samples) / n_samples
    course = (
        share
        if rng.random() < 0.5
        else np.sin(2.0 * np.pi * (rng.uniform(0.5, 2.0) * share + rng.uniform()))
    )
    factor = 1.0 + extent * (course - course.mean()) / np.ptp(course)
    return extent, np.concatenate([[0.0], np.cumsum(factor)[:-1]])


def _power_around(
    modal: NDArray[np.complex128], plant: Plant, mode: int, rate_hz: float, n_samples: int
) -> float:
    """Return the mean power of a(t) over the record, within three half-widths of its mode."""
    n_period = len(modal)
    centre = plant.frequency_hz[mode] * n_period / rate_hz
    reach = max(n_period / n_samples, AROUND * plant.damping_ratio[mode] * centre)
    first, last = max(1, int(centre - reach)), min(n_period // 2, int(np.ceil(centre + reach)) + 1)
    around = np.zeros_like(modal)
    around[first:last] = modal[first:last]
    return float(np.mean(np.abs(in_time(around, n_samples)) ** 2))


def _lines(
    rng: np.random.Generator,
    plant: Plant,
    n_forces: int,
    rate_hz: float,
    edge: float,
    band_hz: Range,
    variance: NDArray[np.float64],
) -> Iterator[tuple[float, NDArray[np.complex128]]]:
    """Yield frequencies and amplitudes of what a machine forces at its own frequencies.

    Half of them lie 0.2 to 5 half-widths from a mode, the others anywhere or at multiples of the
    first; in the channel that sees it most a line has 3 to 100 % of the standard deviation.
    """
    first = 0.0
    for force in range(n_forces, plant.participation.shape[1]):
        hz = _log(rng, band_hz)
        way = rng.random()
        if way < 0.5:
            mode = int(rng.integers(len(plant.frequency_hz)))
            away = _log(rng, (0.2, 5.0)) * plant.damping_ratio[mode] * rng.choice([-1.0, 1.0])
            hz = float(plant.frequency_hz[mode] * (1.0 + away))
        elif way < 0.75 and first and 2.0 * first < band_hz[1]:
            hz = first * int(rng.integers(2, int(band_hz[1] / first) + 1))
        hz = min(hz, HIGHEST * rate_hz)
        first = first or hz
        s = 2j * np.pi * hz
        poles_ = poles(plant)
        shapes, own = plant.shapes, plant.participation[:, force]
        answer = s**2 * (
            shapes @ (own / (s - poles_)) + shapes.conj() @ (own.conj() / (s - poles_.conj()))
        )
        answer = answer * anti_alias(np.array([hz / rate_hz]), edge)
        level = np.max(np.abs(answer) / np.sqrt(2.0 * variance))
        yield hz, np.asarray(answer * _log(rng, (0.03, 1.0)) / level)
