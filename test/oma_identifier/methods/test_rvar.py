"""Vector AR with forgetting: the textbook's recursion, modes that move, a shift by the speed."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.identifier.plant import Plant, simulate
from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.methods.banded import Problem
from oma_identifier.methods.catalogue import identify_by
from oma_identifier.methods.rvar import RecursiveVar
from oma_identifier.methods.var import order_by_description_length, VarSums
from oma_identifier.past_samples import PastSamples
from oma_identifier.settings import IdentificationSettings

SEED, RATE_HZ = 29, 100.0


def recursion(rows: np.ndarray, forgetting: float, order: int, n_instruments: int) -> np.ndarray:
    """Return the poles of sums that are faded and added to, sample after sample."""
    n_channels = rows.shape[1]
    reach = order + n_instruments
    sums = np.zeros(((reach + 1) * n_channels,) * 2)
    for newest in range(reach, len(rows)):
        seen = rows[newest - reach : newest + 1][::-1].ravel()  # the newest first
        sums = forgetting * sums + np.outer(seen, seen)
    now, model = slice(0, n_channels), slice(n_channels, (order + 1) * n_channels)
    past = slice((order + 1) * n_channels, None)
    weight = np.linalg.inv(sums[past, past])
    cross = sums[model, past]
    coefficients = sums[now, past] @ weight @ cross.T @ np.linalg.inv(cross @ weight @ cross.T)
    companion = np.eye(order * n_channels, k=-n_channels)
    companion[:n_channels] = coefficients
    return np.linalg.eigvals(companion)


def test_faded_samples_give_what_the_recursion_with_forgetting_gives():
    rng = np.random.default_rng(SEED)
    plant = Plant(np.array([9.0, 21.0]), np.array([0.02, 0.02]), np.eye(2), np.eye(2))
    rows = simulate(plant, rng, 30.0, RATE_HZ).acceleration
    memory_s, order = 4.0, 6
    settings = IdentificationSettings(window_s=10.0, memory_s=memory_s)
    problem = Problem(rows, 2, None, range(2, 4), np.ones(2), 8.0)
    problem = replace(problem, band=type('Band', (), {'sample_rate_hz': RATE_HZ}))
    faded = RecursiveVar().weighted(problem, settings)
    sums = VarSums(faded.rows, np.array([0, 1]))
    found = sums.poles(order).eigenvalue * np.exp(-0.5 / (memory_s * RATE_HZ))
    expected = recursion(rows, np.exp(-1.0 / (memory_s * RATE_HZ)), order, sums.n_instruments)
    expected = expected[expected.imag > 0.0]
    assert len(found) == len(expected)
    for value in expected:
        # What the order leaves unused may differ; modes, near the circle, may not.
        if abs(value) > 0.9:
            assert np.abs(found - value).min() < 2e-4, f'seed {SEED}: {value}, {found}'


def drifting(seed: int, duration_s: float = 80.0) -> tuple[Samples, np.ndarray]:
    """Return three channels of two modes whose frequencies rise by 0.1 % a second."""
    rng = np.random.default_rng(seed)
    n = int(duration_s * RATE_HZ)
    grown = 1.0 + 1e-3 * np.arange(n) / RATE_HZ
    moved = np.zeros((n, 2))
    for mode, hz in enumerate((8.0, 19.0)):
        s = 2.0 * np.pi * hz * grown * (-0.02 + 1j * np.sqrt(1.0 - 4e-4)) / RATE_HZ
        first, second = 2.0 * np.exp(s.real) * np.cos(s.imag), -np.exp(2.0 * s.real)
        force, last, before = rng.standard_normal(n), 0.0, 0.0
        for row in range(n):
            last, before = first[row] * last + second[row] * before + force[row], last
            moved[row, mode] = last
    moved /= moved.std(axis=0)
    rows = moved @ np.array([[1.0, 0.6, -0.4], [0.5, -1.0, 0.7]])
    rows += 0.03 * rng.standard_normal(rows.shape)
    return Samples(rows, RATE_HZ, tuple(map(Channel, 'abc'))), np.array([8.0, 19.0])


def test_modes_that_move_are_those_of_a_memory_ago():
    """Frequencies and damping in four records, within their own deviations."""
    score = []
    seeds = range(300, 304)
    for seed in seeds:
        samples, hz = drifting(seed)
        settings = IdentificationSettings(window_s=20.0, min_frequency_hz=3.0)
        modes = identify_by('rvar', samples, settings).modes
        assert len(modes) == 2, f'seed {seed}: {modes.frequency_hz}'
        truth_hz = hz * (1.0 + 1e-3 * (samples.duration_s - settings.memory))
        for mode, true_hz in zip(modes, truth_hz, strict=True):
            score.append((mode.frequency_hz - true_hz) / mode.frequency_std_hz)
            score.append((mode.damping_ratio - 0.02) / mode.damping_ratio_std)
            assert mode.frequency_std_hz < 0.015 * true_hz
    spread = np.sqrt(np.mean(np.square(score)))
    # Of 16 values of unit variance it is outside once in 5,000.
    assert 0.4 < spread < 1.7, f'seeds {seeds}: {score}'


@pytest.mark.slow
def test_a_shift_by_the_speed_within_a_record_is_followed():
    """Frequencies of a grinding robot differed by a tenth between two speeds (Mokdad)."""
    rng = np.random.default_rng(SEED)
    shapes, participation = rng.standard_normal((4, 2)), rng.standard_normal((2, 3))
    hz, damping = np.array([9.0, 21.0]), np.array([0.02, 0.02])
    parts = [
        simulate(
            Plant(hz * factor, damping, shapes, participation),
            np.random.default_rng([SEED, speed]),
            60.0,
            RATE_HZ,
        )
        for speed, factor in enumerate((1.0, 0.9))
    ]
    rows = np.concatenate([part.acceleration for part in parts])
    both = replace(parts[0], acceleration=rows)
    settings = IdentificationSettings(window_s=20.0, min_frequency_hz=3.0)
    slow = identify_by('rvar', parts[0], settings).modes
    fast = identify_by('rvar', both, settings).modes
    assert len(slow) == len(fast) == 2
    for modes, factor in ((slow, 1.0), (fast, 0.9)):
        for mode, true_hz in zip(modes, factor * hz, strict=True):
            assert abs(mode.frequency_hz - true_hz) < 3.0 * mode.frequency_std_hz, f'seed {SEED}'
            assert mode.frequency_std_hz < 0.01 * true_hz
    # Without forgetting the speeds are mixed.
    mixed = identify_by('var', both, settings).modes.frequency_hz
    assert not (len(mixed) == 2 and np.all(np.abs(mixed / (0.9 * hz) - 1.0) < 0.02)), mixed


def window(first: int, last: int, rows: np.ndarray) -> Samples:
    return Samples(rows[first:last], 10.0, (Channel('a'),), start_ns=first * 10**8)


def test_windows_that_follow_are_joined_as_far_back_as_is_asked():
    rows = np.arange(400.0)[:, None]
    past = PastSamples(20.0)
    for first, since in ((0, 0), (50, 0), (100, 0), (150, 50)):
        joined = past.up_to(window(first, first + 100, rows))
        np.testing.assert_array_equal(joined.acceleration, rows[since : first + 100])
        assert joined.start_ns == since * 10**8
    # Beyond a gap, or with other channels, a window stands alone.
    alone = past.up_to(window(300, 400, rows))
    np.testing.assert_array_equal(alone.acceleration, rows[300:])
    other = replace(window(350, 400, rows), channels=(Channel('b'),))
    assert past.up_to(other) is not alone and len(past.up_to(other).acceleration) == 50
    whole = window(0, 400, rows)
    assert PastSamples(20.0).up_to(whole) is whole


@pytest.mark.parametrize('shorter', [2, 5])
def test_the_order_follows_from_the_samples_that_count(shorter):
    """Fewer equal samples allow fewer parameters, whatever the number of rows."""
    noise = np.random.default_rng(SEED).standard_normal((2000, 2))
    gram = np.cov(np.concatenate([noise[k : 1990 + k] for k in range(10)], axis=1).T)
    full = order_by_description_length(gram, 2000, 2)
    assert order_by_description_length(gram, 2000 // shorter, 2) <= full
