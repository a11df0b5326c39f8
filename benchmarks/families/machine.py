"""Lines: what a machine forces on a structure at its own frequencies."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.families.chance import log_uniform
from benchmarks.families.family import Range
from benchmarks.families.response import anti_alias, poles
from benchmarks.identifier.plant import Plant

Lines = list[tuple[float, NDArray[np.complex128]]]
LEVEL = (0.03, 1.0)
"""Of a line, over the standard deviation of the response where it is seen most."""


def draw_lines(
    rng: np.random.Generator,
    plant: Plant,
    rate_hz: float,
    edge: float,
    band_hz: Range,
    variance: NDArray[np.float64],
) -> Lines:
    """Draw frequencies [Hz] and complex amplitudes of one line for each force of the plant.

    Half of them lie 0.2 to 5 half-widths from a mode, the others anywhere or at multiples of the
    first.
    """
    lines: Lines = []
    for force in plant.participation.T:
        hz = _frequency(rng, plant, band_hz, lines[0][0] if lines else 0.0)
        answer = _answer(plant, force, hz) * anti_alias(np.array([hz / rate_hz]), edge)
        level = np.max(np.abs(answer) / np.sqrt(2.0 * variance))
        lines.append((hz, answer * log_uniform(rng, LEVEL) / level))
    return lines


def _frequency(rng: np.random.Generator, plant: Plant, band_hz: Range, first: float) -> float:
    hz = log_uniform(rng, band_hz)
    way = rng.random()
    if way < 0.5:
        mode = int(rng.integers(len(plant.frequency_hz)))
        away = log_uniform(rng, (0.2, 5.0)) * plant.damping_ratio[mode] * rng.choice([-1.0, 1.0])
        hz = float(plant.frequency_hz[mode] * (1.0 + away))
    elif way < 0.75 and first and 2.0 * first < band_hz[1]:
        hz = first * int(rng.integers(2, int(band_hz[1] / first) + 1))
    return min(hz, band_hz[1])


def _answer(
    plant: Plant, force: NDArray[np.complex128] | NDArray[np.float64], hz: float
) -> NDArray[np.complex128]:
    """Return the accelerations at a frequency."""
    s, pole, shapes = 2j * np.pi * hz, poles(plant), plant.shapes
    near, far = force / (s - pole), force.conj() / (s - pole.conj())
    return np.asarray(s**2 * (shapes @ near + shapes.conj() @ far))
