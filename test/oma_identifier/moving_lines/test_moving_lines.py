"""Lines that move with a speed: followed, taken out to the floor, and nothing else taken."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import chirp

from benchmarks.identifier.plant import chain_plant, simulate
from benchmarks.methods.milled import Cut, excess_db, milled
from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.methods.catalogue import identify_by
from oma_identifier.motion import never
from oma_identifier.moving_lines import by_modes, by_notch, find_course, without_moving
from oma_identifier.settings import IdentificationSettings
from oma_identifier.window_finder import WindowFinder

RATE_HZ, DURATION_S = 200.0, 60.0


def in_noise(tones: np.ndarray, seed: int) -> Samples:
    rows = np.random.default_rng(seed).standard_normal((len(tones), 3))
    rows += np.outer(tones, [1.0, -0.5, 0.2])
    return Samples(rows, RATE_HZ, tuple(Channel(name) for name in 'abc'))


def even_time() -> np.ndarray:
    return np.arange(round(RATE_HZ * DURATION_S)) / RATE_HZ


@pytest.mark.parametrize('gain', [by_notch, by_modes])
def test_a_chirp_with_its_double_is_followed_and_what_is_left_is_the_noise(gain):
    time = even_time()
    phase = 2.0 * np.pi * (28.5 * time + 0.5 * (3.0 / DURATION_S) * time**2)
    tones = 5.0 * np.cos(phase) + 2.0 * np.cos(2.0 * phase + 1.0)
    samples = in_noise(tones, 3)
    left, lines = without_moving(samples, gain)
    found_hz = sorted(line.frequency_hz for line in lines)
    np.testing.assert_allclose(found_hz, [30.0, 60.0], atol=0.02)
    assert all(line.moved == pytest.approx(0.1, abs=0.005) for line in lines)
    noise = samples.acceleration - np.outer(tones, [1.0, -0.5, 0.2])
    wrong = left.acceleration - noise
    # At most what so many coefficients hold of the noise, and a little of the line.
    assert np.mean(wrong**2) < 0.02, np.mean(wrong**2)


def test_the_modes_of_the_decomposition_are_its_wiener_filters():
    """Against the iteration of the paper, on one component."""
    generator = np.random.default_rng(5)
    n, n_line = 400, 3
    spectrum = generator.standard_normal(n) * np.where(np.arange(n) < 4, 30.0, 1.0)
    alpha = 1.0 / (2.0 * (2.0 * n_line) ** 2)
    component, centre = np.zeros(n), 0.0
    for _ in range(50):
        component = spectrum / (1.0 + 2.0 * alpha * (np.arange(n) - centre) ** 2)
        centre = 0.0  # turned back by its own phase
    np.testing.assert_allclose(by_modes(n_line, n) * spectrum, component, rtol=1e-12)


@pytest.mark.parametrize('seed', range(3))
def test_nothing_moves_in_healthy_records(seed):
    """Modes, light ones too, lines that stand still, bursts and noise alone."""
    rng = np.random.default_rng(seed)
    time = even_time()
    hum = 3.0 * np.cos(2.0 * np.pi * 25.0 * time)
    bursts = np.exp(3.0 * np.sin(2.0 * np.pi * 0.11 * time))[:, None]
    modes = simulate(chain_plant(), rng, DURATION_S, 512.0)
    noise = in_noise(0.0 * time, seed)
    unsteady = Samples(noise.acceleration * bursts, RATE_HZ, noise.channels)
    for samples in (modes, noise, in_noise(hum, seed), unsteady):
        left, lines = without_moving(samples)
        assert left is samples, (seed, lines)


def test_one_chirp_alone_is_a_line_and_short_records_are_refused_quietly():
    samples = in_noise(4.0 * chirp(even_time(), 40.0, DURATION_S, 44.0), 8)
    course = find_course(samples)
    assert course is not None
    np.testing.assert_allclose(course.orders_hz, [42.0], atol=0.03)
    assert find_course(samples.part(slice(0, 500))) is None


@pytest.mark.parametrize(
    'method', ['ssi_cov', 'vmd', pytest.param('notch', marks=pytest.mark.slow)]
)
def test_a_ramp_of_a_tenth_is_removed_and_bends_no_mode(method):
    """Tooth passing 20 to 40 dB above the response, an order 1 % from a mode."""
    record = milled(11, Cut(ramp=0.1))
    found = identify_by(method, record.samples)
    assert found.modes.method == method
    for frequency in record.truth.plant.frequency_hz:
        near = min(found.modes, key=lambda mode: abs(mode.frequency_hz - frequency))
        error = near.frequency_hz - frequency
        if any(abs(frequency / hz - 1.0) < 0.05 for hz in record.truth.lines_hz):
            assert np.isnan(near.frequency_std_hz), frequency  # an order crossed it
            assert abs(error) < 0.02 * frequency
        else:
            assert abs(error) < 3.0 * near.frequency_std_hz, (frequency, near.frequency_hz)
    for order_hz in record.truth.lines_hz:
        assert np.abs(found.harmonics.frequency_hz / order_hz - 1.0).min() < 0.005, order_hz


@pytest.mark.parametrize('seed', range(4))
def test_a_ramp_is_taken_out_to_3_db_of_the_floor(seed):
    record = milled(seed, Cut(ramp=0.1))
    left, _ = without_moving(record.samples)
    assert max(excess_db(record, left)) < 3.0, (seed, excess_db(record, left))
    assert min(excess_db(record, record.samples)) > 10.0


def test_an_order_that_crosses_a_mode_is_taken_as_a_multiple_of_the_others():
    """It is narrow in no time: it grows and falls by 30 dB."""
    record = milled(113, Cut(speed=2, ramp=0.1))
    left, lines = without_moving(record.samples)
    assert len(lines) == len(record.truth.lines_hz)
    assert max(excess_db(record, left)) < 3.0


@pytest.mark.parametrize('ends_hz', [(20.0, 35.0), (5.0, 60.0), (60.0, 30.0)])
def test_a_sweep_that_shakes_the_structure_stays(ends_hz):
    samples = in_noise(4.0 * chirp(even_time(), ends_hz[0], DURATION_S, ends_hz[1]), 9)
    assert without_moving(samples)[0] is samples


def test_windows_of_a_ramp_show_the_modes_and_nothing_else():
    record = milled(301, Cut(speed=1, ramp=0.15))
    finder = WindowFinder(IdentificationSettings(window_s=30.0))
    hz = record.truth.plant.frequency_hz
    for first in (0, 15 * 256):
        part = record.samples.part(slice(first, first + 30 * 256))
        found = finder.find(replace(part, start_ns=first * 3_906_250), never)
        assert len(found.modes) == len(hz)
        np.testing.assert_allclose(found.modes.frequency_hz, hz, rtol=0.02)
        assert len(found.harmonics) == len(record.truth.lines_hz)
