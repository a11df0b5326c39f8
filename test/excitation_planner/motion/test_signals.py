"""Pulses, band-limited noise and their spectra against what is known of them."""

import itertools

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.integrate import quad

from excitation_planner.motion.band_noise import band_noise_velocity, BandNoiseSettings
from excitation_planner.motion.pulses import (
    pulse_velocity,
    PulseSettings,
    PulseShape,
    random_pulses,
    rectangular_train,
)
from excitation_planner.motion.spectrum import predicted_spectrum, whiteness
from excitation_planner.motion.trajectory import Trajectory

PERIOD_S = 0.004
SEED = 20250321


@st.composite
def shapes(draw):
    ramp_s = draw(st.sampled_from([0.0, 0.01, 0.05, 0.1]))
    acceleration_s = draw(st.floats(max(2.0 * ramp_s, 0.02), 1.0))
    return PulseShape(draw(st.floats(2.0 * acceleration_s, 3.0)), acceleration_s, ramp_s)


@given(shapes())
@settings(max_examples=40, deadline=None)
def test_a_unit_pulse_goes_one_and_never_faster_than_it_says(shape):
    time_s = np.linspace(0.0, shape.duration_s, 20001)
    velocity = shape.velocity(time_s)
    assert np.trapezoid(velocity, time_s) == pytest.approx(1.0, rel=1e-4)
    assert np.max(velocity) == pytest.approx(shape.peak_velocity, rel=1e-3)
    acceleration = np.diff(velocity) / np.diff(time_s)
    assert np.max(acceleration) == pytest.approx(shape.peak_acceleration, rel=2e-2)
    assert np.max(acceleration) <= shape.peak_acceleration * (1.0 + 1e-9)


@pytest.mark.parametrize('shape', [PulseShape(0.5, 0.2, 0.05), PulseShape(0.4, 0.2)])
def test_pulse_spectrum_is_the_fourier_transform_of_its_acceleration(shape):
    for frequency_hz in (1.3, 4.7, 11.0, 23.0):
        # Of the velocity by quadrature, times 2 pi f for the derivative.
        def wave(t, turn, f=frequency_hz):
            return shape.velocity(np.array([t]))[0] * turn(2.0 * np.pi * f * t)

        parts = [
            quad(wave, 0.0, shape.duration_s, args=(turn,), limit=400, epsabs=1e-9)[0]
            for turn in (np.cos, np.sin)
        ]
        expected = 2.0 * np.pi * frequency_hz * np.hypot(*parts)
        assert shape.spectrum(np.array([frequency_hz]))[0] == pytest.approx(expected, rel=1e-4)


def test_a_pulse_has_no_energy_at_multiples_of_one_over_its_ramp():
    shape = PulseShape(0.5, 0.2, 0.05)
    peak = np.max(shape.spectrum(np.linspace(0.1, 60.0, 5000)))
    assert np.all(shape.spectrum(np.array([20.0, 40.0, 60.0])) < 1e-9 * peak), '1 / 50 ms'


def pulse_settings(**changes):
    n_joints = 6
    return PulseSettings(
        **{
            'half_range': np.full(n_joints, 0.03),
            'peak_velocity': np.full(n_joints, 2.0),
            'peak_acceleration': np.full(n_joints, 7.0),
            'ramp_s': (0.05, 0.15),
            'acceleration_fraction': (0.2, 0.9),
            **changes,
        }
    )


@given(st.integers(0, 2**32 - 1), st.booleans(), st.floats(0.5, 20.0))
@settings(max_examples=40, deadline=None)
def test_random_pulses_stay_in_range_return_and_rest_between(seed, synchronised, duration_s):
    chosen = pulse_settings(synchronised=synchronised)
    pulses = random_pulses(chosen, duration_s, PERIOD_S, np.random.default_rng(seed))
    if not pulses:
        return
    n_samples = round(duration_s / PERIOD_S) + 1
    velocity = pulse_velocity(pulses, n_samples, PERIOD_S)
    trajectory = Trajectory.from_velocity(np.zeros(6), velocity, PERIOD_S)
    assert np.max(np.abs(trajectory.position)) <= 0.03 * 1.01, seed
    assert np.max(np.abs(trajectory.position[-1])) < 1e-9, seed
    assert np.max(np.abs(trajectory.velocity)) <= 2.0 * 1.001, seed
    assert np.max(np.abs(trajectory.acceleration)) <= 0.9 * 7.0 * 1.05, seed
    assert not velocity[0].any()
    assert not velocity[-1].any()
    for joint in range(6):
        own = [pulse for pulse in pulses if pulse.displacement[joint] != 0.0]
        for first, second in itertools.pairwise(own):
            assert second.start_s >= first.end_s + 0.02 - 1e-9, seed


def test_joints_are_independent():
    chosen = pulse_settings(synchronised=False)
    generator = np.random.default_rng(SEED)
    velocity = pulse_velocity(random_pulses(chosen, 200.0, PERIOD_S, generator), 50001, PERIOD_S)
    correlation = np.corrcoef(velocity.T) - np.eye(6)
    assert np.max(np.abs(correlation)) < 0.15, f'seed {SEED}'


def test_more_pulses_more_energy_in_the_band_of_a_3_ms_pulse():
    """Fig. 10: 1, 8 and 22 rectangles of 3 ms in 1000 samples at 1 kHz."""
    energy = []
    for n_pulses in (1, 8, 22):
        runs = [
            predicted_spectrum(
                rectangular_train(n_pulses, 3, 1000, np.random.default_rng([SEED, run]))[:, None],
                1e-3,
                10.0,
            )
            for run in range(40)
        ]
        density = np.mean([run.density[:, 0] for run in runs], axis=0)
        frequency_hz = runs[0].frequency_hz
        energy.append(np.mean(density[(frequency_hz > 50.0) & (frequency_hz < 200.0)]))
        first_zero = density[np.argmin(np.abs(frequency_hz - 333.0))]
        assert first_zero < 0.02 * energy[-1], 'the band of a 3 ms rectangle ends at 333 Hz'
    ratios = np.array(energy) / energy[0]
    assert ratios == pytest.approx([1.0, 8.0, 22.0], rel=0.25), f'seed {SEED}: energy grows with n'


def noise(**changes):
    values = {'acceleration_rms': np.array([1.0, 0.5, 0.0]), 'band_hz': (5.0, 60.0), **changes}
    velocity = band_noise_velocity(
        BandNoiseSettings(**values), 40.0, PERIOD_S, np.random.default_rng(SEED)
    )
    return Trajectory.from_velocity(np.zeros(3), velocity, PERIOD_S)


def test_band_noise_has_its_strength_band_and_rest():
    motion = noise()
    steady = motion.acceleration[500:-500]
    assert np.std(steady, axis=0)[:2] == pytest.approx([1.0, 0.5], rel=0.06)
    assert not motion.position[:, 2].any(), 'a joint of weight 0 rests'
    assert np.max(np.abs(motion.position[-1])) < 1e-10
    assert not motion.velocity[0].any()
    assert not motion.velocity[-1].any()
    spectrum = predicted_spectrum(motion.acceleration, PERIOD_S)
    power = np.sum(spectrum.density[:, 0])
    outside = (spectrum.frequency_hz < 4.0) | (spectrum.frequency_hz > 61.0)
    assert np.sum(spectrum.density[outside, 0]) < 1e-3 * power
    low, high = spectrum.excited_band_hz()
    assert low == pytest.approx(5.0, abs=0.5)
    assert high == pytest.approx(60.0, abs=0.5)
    assert spectrum.flatness_db((6.0, 59.0)) < 6.0


def test_band_noise_starts_and_ends_without_a_jerk():
    motion = noise()
    edge = np.abs(motion.acceleration[[0, 1, -2, -1]])
    assert np.max(edge) < 1e-3 * np.max(np.abs(motion.acceleration))


def test_band_noise_follows_its_shape():
    motion = noise(shape_frequency_hz=(5.0, 20.0, 21.0, 60.0), shape_gain=(1.0, 1.0, 3.0, 3.0))
    spectrum = predicted_spectrum(motion.acceleration, PERIOD_S)
    low = np.mean(spectrum.at(np.arange(7.0, 18.0))[:, 0])
    high = np.mean(spectrum.at(np.arange(25.0, 55.0))[:, 0])
    assert high / low == pytest.approx(9.0, rel=0.2), f'seed {SEED}: amplitude 3, density 9'


def test_a_resting_joint_does_not_change_the_others():
    with_second = noise().velocity[:, 0]
    without = noise(acceleration_rms=np.array([1.0, 0.0, 0.0])).velocity[:, 0]
    assert np.array_equal(with_second, without)


def test_whiteness_test_accepts_white_and_refuses_coloured_noise():
    generator = np.random.default_rng(SEED)
    white = [
        whiteness(generator.standard_normal(5000), PERIOD_S, (5.0, 60.0)).white for _ in range(200)
    ]
    assert 0.90 <= np.mean(white) <= 0.99, f'seed {SEED}: 5 % of white records are refused'
    coloured = np.cumsum(generator.standard_normal(5000))
    assert not whiteness(coloured, PERIOD_S, (5.0, 60.0)).white


def test_trajectory_between_samples_is_its_own_derivative():
    motion = noise().finer(10)
    step_s = motion.time_s[1] - motion.time_s[0]
    for lower, upper in (
        (motion.position, motion.velocity),
        (motion.velocity, motion.acceleration),
        (motion.acceleration, motion.jerk),
    ):
        slope = (lower[2:] - lower[:-2]) / (2.0 * step_s)
        # Between the samples, where the jerk has no corner; a central difference is short by
        # (2π · 60 Hz · step)² / 6 = 0.4 % at the upper end of the band.
        between = np.arange(1, len(slope) + 1) % 10 != 0
        difference = np.abs(slope - upper[1:-1])[between]
        assert np.max(difference) < 5e-3 * np.max(np.abs(upper))
