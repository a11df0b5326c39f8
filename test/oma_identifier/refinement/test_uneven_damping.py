"""Dampers in a few places couple the modes, as those of joints do: shapes are complex."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from benchmarks.identifier.plant import chain_plant, Plant, simulate, with_uneven_damping
from modal_core.mode import Mode, ModeSet
from oma_identifier.refinement.acceptance import Outcome
from oma_identifier.refinement.refinement import refine

RATE_HZ = 4096.0


def second_order_response(plant: Plant, seed: int, dampers: int, n_samples: int) -> np.ndarray:
    """Return modal accelerations under held forces by the exponential of the whole system."""
    omega = 2.0 * np.pi * plant.frequency_hz
    reach = np.random.default_rng(seed).standard_normal((len(omega), dampers))
    reach *= np.sqrt(2.0 * plant.damping_ratio * omega / np.sum(reach**2, axis=1))[:, None]
    zero, one = np.zeros((len(omega),) * 2), np.eye(len(omega))
    system = np.block([[zero, one], [-np.diag(omega**2), -reach @ reach.T]])
    n_forces = plant.participation.shape[1]
    into = np.vstack([np.zeros_like(plant.participation), plant.participation])
    whole = np.zeros((len(system) + n_forces,) * 2)
    whole[: len(system)] = np.hstack([system, into])
    step = expm(whole / RATE_HZ)[: len(system)]
    forces = np.random.default_rng(seed).standard_normal((n_samples, n_forces))
    state, response = np.zeros(len(system)), np.empty((n_samples, len(omega)))
    for row, force in zip(response, forces, strict=True):
        row[:] = (system @ state + into @ force)[len(omega) :]
        state = step @ np.concatenate([state, force])
    return response @ plant.shapes.T


def test_the_plant_is_that_of_its_coupled_equations():
    """Peaks of the spectra are there, and as high, as integration of the equations makes them."""
    seed, n_samples = 5, 40960
    plant = chain_plant(6, 40.0)
    coupled = with_uneven_damping(plant, np.random.default_rng(seed), 1)
    expected = second_order_response(plant, seed, 1, n_samples)
    frequency = np.fft.rfftfreq(n_samples, 1.0 / RATE_HZ)
    force = np.random.default_rng(seed).standard_normal((n_samples, 6))
    lines = (frequency > 5.0) & (frequency < 45.0)
    window = np.hanning(n_samples)[:, None]
    into = np.fft.rfft(window * force, axis=0)[lines]
    s = 2j * np.pi * frequency[lines, None]
    size = 2.0 * np.pi * coupled.frequency_hz
    zeta = coupled.damping_ratio
    pole = size * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    driven = into @ coupled.participation.T, into @ coupled.participation.conj().T
    modal = [s**2 * driven[0] / (s - pole), s**2 * driven[1] / (s - pole.conj())]
    found = modal[0] @ coupled.shapes.T + modal[1] @ coupled.shapes.conj().T
    known = np.fft.rfft(window * expected, axis=0)[lines]
    # The window hides the beginning and smears by a line.
    assert np.linalg.norm(found - known) < 0.1 * np.linalg.norm(known)
    straight = coupled.shapes * np.exp(-0.5j * np.angle(np.sum(coupled.shapes**2, axis=0)))
    assert np.max(np.abs(straight.imag)) > 0.05 * np.max(np.abs(straight.real))


@pytest.mark.parametrize('seed', [6100, pytest.param(6101, marks=pytest.mark.slow)])
def test_modes_beside_a_strong_one_are_refined(seed):
    """What is left of the strong mode's complex shape after projecting it out is in the model."""
    generator = np.random.default_rng(seed)
    plain = chain_plant(42)
    strong = np.where(plain.frequency_hz == 107.2, 6.0, 1.0)[:, None]
    plant = replace(plain, participation=plain.participation * strong)
    plant = with_uneven_damping(plant, generator, 1)
    samples = simulate(plant, generator, 60.0, 512.0, simulation_rate_hz=16384.0)
    modes = [
        Mode(frequency, damping, shape / np.abs(shape).max())
        for frequency, damping, shape in zip(
            plant.frequency_hz, plant.damping_ratio, plant.shapes.T, strict=True
        )
    ]
    found = refine(samples, ModeSet(tuple(modes), samples.channel_names))
    assert set(found.outcomes) == {Outcome.REFINED}, f'seed {seed}: {found.outcomes}'
    assert np.all(found.misfit < 1.15), f'seed {seed}: {found.misfit}'
    score = np.array(
        [
            [
                (mode.frequency_hz - truth_hz) / mode.frequency_std_hz,
                (mode.damping_ratio - truth) / mode.damping_ratio_std,
            ]
            for mode, truth_hz, truth in zip(
                found.modes, plant.frequency_hz, plant.damping_ratio, strict=True
            )
        ]
    )
    assert np.sqrt(np.mean(score**2)) < 1.4, f'seed {seed}: {score}'
