"""Vector AR against exact processes, and what measurement noise does to it."""

import numpy as np
import pytest
from scipy.signal import lfilter

from benchmarks.identifier.plant import Plant, simulate
from oma_identifier.methods.catalogue import identify_by
from oma_identifier.methods.var import order_by_description_length, VarSums

SEED = 23


def test_free_decays_give_their_poles_and_shapes_exactly():
    """Two modes in three channels, no noise: order 2 of two references is the exact model."""
    mu = np.exp(np.array([-0.001 + 0.5j, -0.002 + 1.3j]))
    shapes = np.random.default_rng(SEED).standard_normal((3, 2)) + 0.3j
    time = np.arange(2000)
    rows = np.real(shapes @ (mu[:, None] ** time)).T
    found = VarSums(rows, np.array([0, 2])).poles(2)
    for value, shape in zip(mu, shapes.T, strict=True):
        near = int(np.argmin(np.abs(found.eigenvalue - value)))
        assert abs(found.eigenvalue[near] - value) < 1e-7
        ratio = found.shape[:, near] / shape
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-4)


def oscillator(mu: complex, seed: int, n: int = 20_000, noise: float = 0.3) -> np.ndarray:
    """Return the textbook's AR(2), a1 = 2 Re μ, a2 = -|μ|², under measurement noise."""
    rng = np.random.default_rng(seed)
    clean = lfilter([1.0], [1.0, -2.0 * mu.real, abs(mu) ** 2], rng.standard_normal(n + 2000))
    clean = clean[2000:] / clean[2000:].std()
    return (clean + noise * rng.standard_normal(n))[:, None]


def test_noise_does_not_bias_the_damping_as_it_does_by_least_squares():
    truth = complex(np.exp(-0.01 + 0.8j))
    ours, plain = [], []
    seeds = range(100, 120)
    for seed in seeds:
        rows = oscillator(truth, seed)
        coefficients = VarSums(rows, np.array([0])).coefficients(2)[0]
        ours.append(-np.log(np.abs(np.roots([1.0, *-coefficients])[0])))
        past = np.stack([rows[1:-1, 0], rows[:-2, 0]], axis=1)
        least = np.linalg.lstsq(past, rows[2:, 0], rcond=None)[0]
        plain.append(-np.log(np.abs(np.roots([1.0, *-least])[0])))
    assert np.mean(plain) > 0.05, f'seeds {seeds}: least squares, the trap: {np.mean(plain)}'
    # The lowest order under strong noise is the worst case: instruments that say little each
    # leave a tenth of the damping, less than the scatter of a run.
    assert abs(np.mean(ours) - 0.01) < 0.0015, f'seeds {seeds}: {np.mean(ours)}'


def test_order_of_an_autoregressive_process_is_found():
    for seed in range(5):
        noise = np.random.default_rng(seed).standard_normal(5000)
        assert chosen_order(lfilter([1.0], [1.0, -1.2, 0.9, -0.5, 0.2], noise)) == 4, seed
        assert chosen_order(noise) == 0, seed


def chosen_order(series: np.ndarray) -> int:
    stacked = np.stack([series[first : 4980 + first] for first in range(13)])
    return order_by_description_length(stacked @ stacked.T / 4980, 4980, 1)


@pytest.mark.parametrize('duration_s', [20.0, 60.0])
@pytest.mark.slow
def test_a_shift_by_the_speed_shows_in_short_records(duration_s):
    """Frequencies of a grinding robot differed by a tenth between two speeds (Mokdad)."""
    rng = np.random.default_rng(SEED)
    shapes, participation = rng.standard_normal((4, 2)), rng.standard_normal((2, 3))
    damping = np.array([0.02, 0.02])
    found = []
    for speed, factor in enumerate((1.0, 0.9)):
        plant = Plant(np.array([9.0, 21.0]) * factor, damping, shapes, participation)
        record = simulate(plant, np.random.default_rng(SEED + speed), duration_s, 100.0)
        modes = identify_by('var', record).modes
        assert len(modes) == 2, modes.frequency_hz
        found.append(modes)
    for slow, fast in zip(*found, strict=True):
        ratio = fast.frequency_hz / slow.frequency_hz
        std = ratio * np.hypot(
            slow.frequency_std_hz / slow.frequency_hz, fast.frequency_std_hz / fast.frequency_hz
        )
        assert abs(ratio - 0.9) < 3.0 * std, (ratio, std)
        assert std < 0.01
