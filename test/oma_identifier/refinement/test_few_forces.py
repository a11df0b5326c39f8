"""Refinement where fewer forces than modes act: tails of all modes are coherent."""

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.refinement import refine
from oma_identifier.refinement.refining import Record

RATE_HZ, DURATION_S = 64.0, 400.0
N_MODES, N_CHANNELS, NOISE = 10, 7, 0.02
SEEDS = range(4200, 4204)


def record(seed: int, n_forces: int) -> tuple[Samples, ModeSet]:
    """Return a stretch of an endless motion of a chain-like structure, and its modes."""
    generator = np.random.default_rng(seed)
    frequency = np.linspace(2.0, 24.0, N_MODES) * generator.uniform(0.95, 1.05, N_MODES)
    damping = generator.uniform(0.004, 0.012, N_MODES)
    shapes = generator.standard_normal((N_CHANNELS, N_MODES))
    drive = generator.standard_normal((N_MODES, n_forces))
    n = int(RATE_HZ * DURATION_S)
    lines = np.arange(n + 1) * RATE_HZ / (2 * n)  # of twice the length, cut in half
    force = generator.standard_normal((n_forces, n + 1, 2)) @ (1.0, 1.0j)
    ratio = lines / frequency[:, None]
    gain = -(ratio**2) / (1.0 - ratio**2 + 2j * damping[:, None] * ratio)
    values = np.fft.irfft(shapes @ (gain * (drive @ force)), n=2 * n)[:, :n].T
    values += NOISE * values.std() * generator.standard_normal(values.shape)
    samples = Samples(values, RATE_HZ, tuple(Channel(f'c{at}') for at in range(N_CHANNELS)))
    modes = tuple(
        Mode(f, z, (shape / shape[np.argmax(np.abs(shape))]).astype(complex))
        for f, z, shape in zip(frequency, damping, shapes.T, strict=True)
    )
    return samples, ModeSet(modes, samples.channel_names)


def nearby(modes: ModeSet, seed: int) -> ModeSet:
    """Return what a first identification may have found of them."""
    generator = np.random.default_rng([seed, 1])
    found = []
    for mode in modes:
        shape = mode.shape + 0.02 * (generator.standard_normal((N_CHANNELS, 2)) @ (1.0, 0.3j))
        off, wider = generator.standard_normal(2)
        f = mode.frequency_hz * (1.0 + 0.1 * mode.damping_ratio * off)
        found.append(Mode(f, mode.damping_ratio * np.exp(0.1 * wider), shape))
    return ModeSet(tuple(found), modes.channel_names)


@pytest.mark.parametrize('n_forces', [1, 2, 3])
def test_few_forces_are_counted_and_never_one_too_few(n_forces):
    samples, modes = record(SEEDS[0], n_forces)
    counted = Record.of(samples, modes, None, (), None).n_forces
    assert n_forces <= counted <= n_forces + 3


def test_as_many_forces_as_modes_are_not_few():
    samples, modes = record(SEEDS[0], N_MODES)
    assert Record.of(samples, modes, None, (), None).n_forces == 0


@pytest.mark.slow
def test_modes_under_two_forces_are_refined_and_their_deviations_cover_the_truth():
    off, said = [], 0
    for seed in SEEDS:
        samples, true = record(seed, 2)
        found = refine(samples, nearby(true, seed), is_whole=True)
        for mode, right in zip(found.modes, true, strict=True):
            if mode.shape_std is None:
                continue
            said += 1
            off.append((mode.frequency_hz - right.frequency_hz) / mode.frequency_std_hz)
            off.append((mode.damping_ratio - right.damping_ratio) / mode.damping_ratio_std)
    assert said >= 0.9 * N_MODES * len(SEEDS), f'{said} refined, seeds {SEEDS}'
    squares = np.square(off)
    # 80 squares of unit mean have a standard deviation of 0.16 about it.
    assert 0.5 < squares.mean() < 1.6, f'{squares.mean()}, seeds {SEEDS}'
    assert np.mean(squares < 4.0) > 0.88, f'seeds {SEEDS}'
