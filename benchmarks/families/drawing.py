"""Records drawn by family and seed alone."""

from dataclasses import dataclass, replace
import zlib

import numpy as np
from numpy.typing import NDArray

from benchmarks.families.chance import log_uniform, whole
from benchmarks.families.family import Family, Range
from benchmarks.families.force import draw_envelope, draw_spectrum, Envelope, Spectrum
from benchmarks.families.machine import draw_lines
from benchmarks.families.motion import draw_motion
from benchmarks.families.record import Record
from benchmarks.families.response import (
    draw_force,
    in_time,
    modal_accelerations,
    period,
    power_around,
)
from benchmarks.families.structure import (
    coupled,
    draw_damping,
    draw_frequencies,
    draw_shapes,
    Modal,
)
from benchmarks.identifier.plant import Plant

MOST_SAMPLES, MOST_VALUES, MOST_DRIFTING = 250_000, 2_500_000, 50_000
"""Samples, samples x channels, and samples where frequencies drift: a record takes seconds."""
FEWEST_SAMPLES = 1000
HIGHEST = 0.4
"""Highest natural frequency over the sample rate."""


@dataclass(frozen=True)
class Grid:
    """Samples of a record and the band of its modes."""

    rate_hz: float
    n_samples: int
    n_channels: int
    band_hz: Range


@dataclass(frozen=True)
class Excitation:
    """Forces, the filter before the converter, and the modes' own time [samples] if they drift."""

    kind: str
    spectrum: Spectrum
    envelope: Envelope
    edge: float
    drift: float
    own_time: NDArray[np.float64] | None

    @property
    def steady(self) -> float:
        """Share of the record in which steady forces would tell as much."""
        power = self.envelope**2
        return float(np.mean(power) ** 2 / np.mean(power**2))


def draw(family: Family, seed: int) -> Record:
    """Draw the record of a seed."""
    rng = np.random.default_rng([seed, zlib.crc32(family.name.encode())])
    grid = _grid(rng, family)
    every, n_forces = _plant(rng, family, grid)
    excitation = _excitation(rng, family, grid)
    plant = replace(every, participation=every.participation[:, :n_forces])
    clean, own = _responses(rng, plant, grid, excitation)
    variance = clean.var(axis=0)
    machine = replace(every, participation=every.participation[:, n_forces:])
    lines = draw_lines(rng, machine, grid.rate_hz, excitation.edge, grid.band_hz, variance)
    time = np.arange(grid.n_samples) / grid.rate_hz
    for hz, amplitude in lines:
        clean += np.real(np.outer(np.exp(2j * np.pi * hz * time), amplitude))
    noise, deviation = log_uniform(rng, family.noise), np.sqrt(variance)
    mean = deviation.mean()
    if family.motion[1]:
        clean += draw_motion(rng, clean.shape, grid.rate_hz, grid.band_hz[0], family.motion) * mean
    level = noise * (deviation if rng.random() < 0.5 else np.full(grid.n_channels, mean))
    scale = 10.0 ** rng.uniform(-2.0, 1.0) / mean
    return Record(
        family=family.name,
        seed=seed,
        plant=replace(plant, participation=scale * plant.participation),
        acceleration=scale * (clean + level * rng.standard_normal(clean.shape)),
        rate_hz=grid.rate_hz,
        share=np.mean(own / variance, axis=1),
        lines_hz=tuple(hz for hz, _ in lines),
        drift=excitation.drift,
        noise=noise,
        noise_std=scale * level,
        n_forces=n_forces,
        forces=excitation.kind + (' moving' if family.motion[1] else ''),
        gain=excitation.spectrum(plant.frequency_hz),
        steady=excitation.steady,
    )


def _grid(rng: np.random.Generator, family: Family) -> Grid:
    rate_hz = float(f'{log_uniform(rng, family.rate_hz):.3g}')
    n_channels = whole(rng, family.n_channels)
    most = min(MOST_SAMPLES, MOST_VALUES // n_channels)
    if family.drift[1] > 0.0:
        most = min(most, MOST_DRIFTING)
    wanted = int(log_uniform(rng, family.duration_s) * rate_hz)
    n_samples = min(most, max(FEWEST_SAMPLES, wanted))
    lowest_hz = max(rate_hz * 10.0 ** -rng.uniform(1.3, 2.5), 10.0 * rate_hz / n_samples)
    return Grid(rate_hz, n_samples, n_channels, (lowest_hz, HIGHEST * rate_hz))


def _plant(rng: np.random.Generator, family: Family, grid: Grid) -> tuple[Plant, int]:
    """Draw the plant and the number of its forces; those of machines come after them.

    One with an overdamped mode is coupled half as much.
    """
    n_modes = whole(rng, family.n_modes)
    frequency_hz = draw_frequencies(rng, n_modes, *grid.band_hz, family.pairs)
    n_forces = max(1, round(rng.uniform(*family.rank) * n_modes))
    n_lines = int(rng.integers(family.n_lines[0], family.n_lines[1] + 1))
    omega = 2.0 * np.pi * frequency_hz
    damping = draw_damping(rng, omega, family.damping)
    shapes = draw_shapes(rng, grid.n_channels, n_modes)
    forces = rng.standard_normal((n_modes, n_forces + n_lines))
    # Forces that are equal over frequency let high modes swamp the low ones.
    forces *= (frequency_hz[:, None] / frequency_hz[0]) ** -0.4
    forces *= np.exp(0.5 * rng.standard_normal((n_modes, 1)))
    share = float(rng.uniform(*family.coupling))
    while True:
        plant = Modal(omega, coupled(rng, damping, share), shapes, forces).plant()
        if plant is not None:
            return plant, n_forces
        share = 0.5 * share if share > 0.01 else 0.0


def _excitation(rng: np.random.Generator, family: Family, grid: Grid) -> Excitation:
    kind, course = str(rng.choice(family.forces)), str(rng.choice(family.courses))
    spectrum = draw_spectrum(rng, kind, *grid.band_hz)
    envelope = draw_envelope(rng, course, grid.n_samples)
    edge = float(rng.choice([0.5, rng.uniform(0.42, 0.48)]))
    drift, own_time = _drift(rng, family.drift, grid.n_samples)
    return Excitation(f'{kind} {course}', spectrum, envelope, edge, drift, own_time)


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


def _responses(
    rng: np.random.Generator, plant: Plant, grid: Grid, excitation: Excitation
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the responses without noise, and the variance of each mode's own near it.

    Returns
    -------
    responses : (n_samples, n_channels) array
    own : (n_modes, n_channels) array
    """
    n_samples, rate_hz = grid.n_samples, grid.rate_hz
    force = draw_force(
        rng,
        plant.participation.shape[1],
        period(plant, n_samples, rate_hz),
        rate_hz,
        excitation.spectrum,
        excitation.envelope,
    )
    responses, own = np.zeros((n_samples, grid.n_channels)), []
    spectra = modal_accelerations(plant, force, rate_hz, excitation.edge)
    for mode, modal in enumerate(spectra):
        shape = plant.shapes[:, mode]
        of_mode = in_time(modal, n_samples, excitation.own_time)
        responses += 2.0 * np.real(np.outer(of_mode, shape))
        power = power_around(modal, plant, mode, rate_hz, n_samples)
        own.append(2.0 * np.abs(shape) ** 2 * power)
    return responses, np.array(own)
