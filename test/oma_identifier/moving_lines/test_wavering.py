"""Lines of a speed that is held, to a part in a thousand: found, or told, but no modes."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.methods.milled import Cut, milled
from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.moving_lines import MovingLine, wavering_course, with_moving, without_moving
from oma_identifier.moving_lines.asked import chance_of
from oma_identifier.moving_lines.course import cosine_coefficients
from oma_identifier.moving_lines.near_band import NearBand
from oma_identifier.selection import Identified, nothing_in

RATE_HZ, DURATION_S, TIME_CONSTANT_S = 256.0, 60.0, 3.0


def held_speed(seed: int, speed_hz: float, waver: float) -> np.ndarray:
    """Return a speed that wanders about its mean (Ornstein and Uhlenbeck) [Hz]."""
    rng = np.random.default_rng(seed)
    keep = np.exp(-1.0 / (TIME_CONSTANT_S * RATE_HZ))
    steps = rng.standard_normal(round(RATE_HZ * DURATION_S)) * np.sqrt(1.0 - keep**2)
    wander = np.empty_like(steps)
    last = rng.standard_normal()
    for at, step in enumerate(steps):
        wander[at] = last = keep * last + step
    return speed_hz * (1.0 + waver * wander)


def orders_in_noise(seed: int, waver: float, orders: tuple[int, ...] = (2, 3, 5)) -> Samples:
    speed = held_speed(seed, 13.0, waver)
    phase = 2.0 * np.pi * np.cumsum(speed) / RATE_HZ
    rng = np.random.default_rng([seed, 1])
    rows = rng.standard_normal((len(phase), 4))
    for order in orders:
        rows += np.outer(np.cos(order * phase + rng.uniform(0.0, 6.28)), rng.uniform(0.5, 1.0, 4))
    return Samples(rows, RATE_HZ, tuple(Channel(name) for name in 'abcd'))


@pytest.mark.parametrize('seed', range(700_500, 700_504))
def test_orders_of_a_held_speed_are_found_and_taken_out(seed):
    samples = orders_in_noise(seed, 0.002)
    course = wavering_course(samples)
    assert course is not None
    left, lines = without_moving(samples)
    found_hz = sorted(line.frequency_hz for line in lines if line.taken)
    np.testing.assert_allclose(found_hz, [26.0, 39.0, 65.0], rtol=3e-3)
    np.testing.assert_allclose(left.widened().std(axis=0), 1.0, atol=0.03)


@pytest.mark.parametrize('seed', range(700_510, 700_513))
def test_steady_lines_and_modes_do_not_waver(seed):
    assert wavering_course(orders_in_noise(seed, 0.0)) is None
    for cut in (Cut(), Cut(turns=False)):
        assert wavering_course(milled(seed, cut).samples) is None


def test_a_narrow_band_of_the_transform_is_that_of_the_samples():
    """At a frequency between spectral lines, of a line that wavers, in an awkward length."""
    near = NearBand.of(orders_in_noise(700_520, 0.002).widened()[:15_013], RATE_HZ)
    turn = 2.0 * np.pi * 39.007 * np.arange(near.n_rows) / RATE_HZ
    expected = cosine_coefficients(np.exp(-1j * turn)[:, None] * near.rows)[:40]
    found = near.coefficients(39.007, 40)
    assert np.linalg.norm(found - expected) < 0.05 * np.linalg.norm(expected)


@pytest.mark.parametrize('n_channels', [1, 5])
def test_chance_of_responses_that_are_none(n_channels):
    """2,000 stretches of one covariance: a hundredth of the chances is below a hundredth."""
    rng = np.random.default_rng(700_530)
    mixed = rng.standard_normal((n_channels, n_channels))
    chances = []
    for _ in range(2000):
        level = rng.standard_normal((28, 2, n_channels)) @ mixed
        level = level[:, 0] + 1j * level[:, 1]
        chances.append(chance_of(level[:4], level[4:]))
    for chance in (0.1, 0.01):
        expected = 2000 * chance
        assert abs(np.sum(np.array(chances) < chance) - expected) < 4.0 * np.sqrt(expected)


def test_weak_orders_are_asked_about_where_the_strong_ones_are_even():
    """Orders 2 and 4 are 20 dB over those that stand between them and below them."""
    samples = orders_in_noise(700_540, 0.002, (4, 8))
    speed = held_speed(700_540, 13.0, 0.002)
    phase = 2.0 * np.pi * np.cumsum(speed) / RATE_HZ
    weak = sum(np.cos(order * phase + order) for order in (1, 3, 7)) * np.full((4, 1), 0.1)
    samples = replace(samples, acceleration=samples.widened() + weak.T)
    left, lines = without_moving(samples)
    found = sorted(line.frequency_hz / speed.mean() for line in lines if line.taken)
    np.testing.assert_allclose(found, [1.0, 3.0, 4.0, 7.0, 8.0], rtol=1e-3)
    np.testing.assert_allclose(left.widened().std(axis=0), 1.0, atol=0.03)


def found_with(*modes: Mode) -> Identified:
    names = ('a', 'b')
    samples = Samples(np.zeros((2, 2)), RATE_HZ, tuple(Channel(name) for name in names))
    nothing = nothing_in(samples, 'ssi_cov')
    return replace(nothing, modes=ModeSet(modes, names, 'ssi_cov'))


def mode(hz: float, damping: float) -> Mode:
    return Mode(hz, damping, np.array([1.0, 0.5j]), frequency_std_hz=0.01)


def test_what_is_at_a_wavering_line_is_in_doubt_and_modes_beside_it_have_no_deviation():
    line = MovingLine(50.0, 0.004, np.array([1.0, 1.0j]), reach_hz=0.1)
    rest, beside, beyond = mode(50.1, 0.002), mode(51.2, 0.02), mode(54.0, 0.02)
    found = with_moving(found_with(rest, beside, beyond), [line])
    assert [each.frequency_hz for each in found.modes] == [51.2, 54.0]
    assert [np.isnan(each.frequency_std_hz) for each in found.modes] == [True, False]
    assert found.doubtful_hz == (50.0,)
    # Nor is there a mode at a multiple that must be there.
    expected = replace(line, moved=0.01, taken=False, reach_hz=0.0)
    found = with_moving(found_with(rest, beside), [expected])
    assert [each.frequency_hz for each in found.modes] == [51.2]
    assert len(found.harmonics) == len(found.doubtful_hz) == 1
    # A line that sweeps past a light mode does not hide it.
    sweeping = replace(line, moved=0.1)
    assert len(with_moving(found_with(rest), [sweeping]).modes) == 1
