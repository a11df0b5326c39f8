"""Nothing that only lines explain is a mode; what responds beside lines stays one."""

from dataclasses import replace
import logging

import numpy as np
import pytest
from scipy.signal import lfilter

from benchmarks.identifier.plant import Plant, simulate
from benchmarks.identifier.scatter import match
from modal_core.measurements import SampleBlock
from modal_core.mode import Mode, ModeSet
from oma_identifier.identify import identify_samples
from oma_identifier.methods import identify_by
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.result import ONLY_LINES
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra.line_evidence import LineEvidence
from oma_identifier.spectra.sinusoids import fit_sinusoids


def sines(seed, rate_hz, duration_s, lines_hz, noise_db, n_channels, modulated=0.0, wander=0.0):
    """Return rows of sines of random sizes and phases, the noise below them by so many dB.

    Their sizes are modulated by a share, their phases by so many radians of the first line, 2.3
    periods over the record.
    """
    rng = np.random.default_rng(seed)
    time = np.arange(int(rate_hz * duration_s)) / rate_hz
    rows = np.zeros((len(time), n_channels))
    slow = 2.0 * np.pi * 2.3 / duration_s * time
    for hz in lines_hz:
        size = rng.standard_normal(n_channels) * np.exp(rng.normal())
        envelope = 1.0 + modulated * np.sin(slow + hz)
        turned = wander * hz / lines_hz[0] * np.cos(slow) + rng.uniform(0.0, 6.0)
        rows += np.outer(np.sin(2.0 * np.pi * hz * time + turned) * envelope, size)
    noise = rng.standard_normal(rows.shape)
    return rows + rows.std() * 10.0 ** (noise_db / 20.0) * noise


def through_pipeline(rows, rate_hz):
    pipeline = IdentificationPipeline(
        IdentificationSettings(window_s=min(60.0, len(rows) / rate_hz))
    )
    names = tuple(f'c{index}' for index in range(rows.shape[1]))
    for first in range(0, len(rows), 100):
        part = rows[first : first + 100]
        stamp_ns = round(first * 1e9 / rate_hz)
        pipeline.add(SampleBlock('lines', stamp_ns, first, rate_hz, names, part))
    windows = [pipeline.identify(window) for window in pipeline.windows()]
    windows += [pipeline.identify(window) for window in pipeline.finish()]
    return [*windows, pipeline.whole()]


CASES = {
    'harmonic series': (3, 200.0, 60.0, 7.3 * np.arange(1, 10), -60.0, 4, 0.0),
    'arbitrary, hardly any noise': (4, 100.0, 150.0, (3.1, 8.8, 17.3, 30.9), -100.0, 8, 0.0),
    'one channel': (5, 103.0, 212.0, (7.05, 14.1), -80.0, 1, 0.0),
    'modulated': (6, 72.0, 100.0, (5.2, 9.9, 13.7, 20.3, 28.8), -40.0, 2, 0.03),
    'in noise': (7, 155.0, 94.0, 8.1 * np.arange(1, 6), -40.0, 11, 0.0),
    'loud noise': (8, 88.0, 130.0, (4.4, 9.8, 25.1), -20.0, 3, 0.0),
    'modulated, hardly any noise': (71, 72.0, 60.0, (5.2, 9.9, 13.7, 20.3, 28.8), -100.0, 2, 0.1),
    'a series that wanders': (72, 100.0, 60.0, 5.3 * np.arange(1, 7), -80.0, 3, 0.0, 0.3),
    'wandering, one channel': (74, 128.0, 74.0, (11.67, 23.34, 35.0), -80.0, 1, 0.0, 0.1),
    'wandering, no noise': (75, 155.0, 65.0, (7.9,), -200.0, 2, 0.0, 0.1),
    'strongly modulated': (77, 100.0, 66.0, (9.1, 20.6, 33.0), -70.0, 1, 0.3),
}


@pytest.mark.parametrize('case', CASES)
def test_sines_are_no_modes(case):
    rows = sines(*CASES[case])
    for result in through_pipeline(rows, CASES[case][1]):
        assert len(result.modes) == 0, result.modes.frequency_hz
        assert len(result.harmonics) > 0
        assert not result.quality.identifiable
        assert result.quality.reason == ONLY_LINES


def test_what_modulation_leaves_over_a_record_is_no_mode():
    lines_hz = 1.3 * np.arange(1, 5)
    *_, whole = through_pipeline(sines(34, 50.0, 182.0, lines_hz, -80.0, 2, 0.03), 50.0)
    assert len(whole.modes) == 0, whole.modes.frequency_hz
    assert len(whole.harmonics) > 0


@pytest.mark.parametrize('method', ['ssi_data', 'plscf', 'efdd', 'fdd'])
@pytest.mark.slow
def test_no_method_makes_modes_of_strong_sines(structure, method):
    like = structure((9.0,), (0.02,), n_channels=4).simulate(np.random.default_rng(1), 60.0, 200.0)
    rows = sines(*CASES['harmonic series'])
    assert len(identify_by(method, replace(like, acceleration=rows)).modes) == 0


def test_modes_beside_strong_lines_stay(structure):
    known = structure((6.0, 14.0, 23.0), (0.01, 0.02, 0.005))
    for seed in range(30, 34):
        clean = known.simulate(np.random.default_rng(seed), 120.0, 100.0)
        lines_hz = (3.3, 10.4, 14.6, 31.7)
        strong = 20.0 * clean.acceleration.std() * sines(seed, 100.0, 120.0, lines_hz, -200.0, 6)
        mixed = replace(clean, acceleration=clean.acceleration + strong)
        found = identify_samples(mixed).modes.frequency_hz
        np.testing.assert_allclose(found, (6.0, 14.0, 23.0), rtol=0.01, err_msg=f'seed {seed}')


def test_without_lines_no_mode_is_explained(structure):
    for seed in range(40, 44):
        samples = structure((6.0, 14.0), (0.002, 0.02)).simulate(
            np.random.default_rng(seed), 120.0, 100.0
        )
        found = identify_samples(samples).modes
        assert len(found) == 2, f'seed {seed}'
        evidence = LineEvidence.of(samples, (), found)
        assert not any(evidence.explains(mode) for mode in found), f'seed {seed}'


def test_a_mode_that_rings_all_the_time_explains_no_other_one(caplog):
    """Without a line for sure there is nothing to explain a mode by."""
    caplog.set_level(logging.DEBUG, 'oma_identifier')
    frequency_hz, duration_s, seeds = np.array([2.5, 3.0, 3.1]), 30.0, range(300, 310)
    n_found = 0
    for seed in seeds:
        rng = np.random.default_rng(seed)
        plant = Plant(
            frequency_hz,
            np.array([0.4, 0.4, 8.0]) / (frequency_hz * duration_s),
            rng.standard_normal((12, 3)),
            rng.standard_normal((3, 3)),
        )
        samples = simulate(plant, rng, duration_s, 20.0, 0.02, simulation_rate_hz=100.0)
        values, _ = match(identify_samples(samples).modes, plant)
        n_found += int(np.isfinite(values[0, 0, 0]))
    assert 'lines explain it' not in caplog.text, seeds
    assert n_found >= len(seeds) - 2, f'seeds {seeds}: {n_found}'


@pytest.mark.parametrize('damping_ratio', [0.002, 0.01, 0.03])
def test_a_mode_has_skirts(structure, damping_ratio):
    known = structure((12.0,), (damping_ratio,), n_channels=3)
    mode = Mode(12.0, damping_ratio, known.shapes[:, 0])
    for seed in range(90, 130):
        samples = known.simulate(np.random.default_rng(seed), 60.0, 100.0)
        evidence = LineEvidence.of(samples, (), ModeSet((mode,), samples.channel_names))
        assert not evidence.explains(mode), f'seed {seed}'


@pytest.mark.parametrize('damping_ratio', [0.01, 0.03])
def test_a_modulated_line_has_no_skirts(structure, damping_ratio):
    """It is modulated at the rate at which the supposed mode would decay."""
    known = structure((12.0,), (damping_ratio,), n_channels=3)
    mode, time = Mode(12.0, damping_ratio, known.shapes[:, 0]), np.arange(6000) / 100.0
    for seed in range(90, 110):
        rng = np.random.default_rng(seed)
        like = known.simulate(rng, 60.0, 100.0)
        swing = 12.0 * damping_ratio * 2.0 * np.pi * time + rng.uniform(0.0, 6.0)
        line = np.sin(2.0 * np.pi * 12.0 * time) * (1.0 + 0.9 * np.sin(swing))
        noise = 1e-4 * rng.standard_normal((6000, 3))
        samples = replace(like, acceleration=np.outer(line, (1.0, 0.4, -0.7)) + noise)
        evidence = LineEvidence.of(samples, (), ModeSet((mode,), samples.channel_names))
        assert evidence.explains(mode), f'seed {seed}'


def driven_by_one_force(rng, frequency_hz, damping_ratio, shapes, rate_hz=100.0, n=6000):
    """Return accelerations of modes that one white force shakes, by their difference equation."""
    force, rows = rng.standard_normal(n), np.zeros((n, len(shapes)))
    for hz, ratio, shape in zip(frequency_hz, damping_ratio, shapes.T, strict=True):
        pole = 2.0 * np.pi * hz / rate_hz * complex(-ratio, np.sqrt(1.0 - ratio**2))
        z = np.exp(pole)
        moved = lfilter([1.0, -2.0, 1.0], [1.0, -2.0 * z.real, abs(z) ** 2], force)
        rows += np.outer(moved, shape)
    return rows + 0.01 * rows.std() * rng.standard_normal(rows.shape)


def test_modes_that_one_force_shakes_together_have_skirts(structure):
    """Between them, in channels where both move alike, there is an antiresonance."""
    like = structure((12.0,), (0.01,), n_channels=5).simulate(
        np.random.default_rng(0), 60.0, 100.0
    )
    for seed in range(300, 360):
        rng = np.random.default_rng(seed)
        hz = 12.0 * np.cumprod(rng.uniform(1.08, 1.25, 3))
        ratio, shapes = rng.uniform(0.005, 0.02, 3), np.abs(rng.standard_normal((5, 3)))
        shapes *= (0.2, 1.0, 0.2)
        rows = driven_by_one_force(rng, hz, ratio, shapes)
        modes = ModeSet(tuple(map(Mode, hz, ratio, shapes.T.astype(complex))), like.channel_names)
        evidence = LineEvidence.of(replace(like, acceleration=rows), (), modes)
        lost = [mode.frequency_hz for mode in modes if evidence.explains(mode)]
        assert not lost, f'seed {seed}'


def test_noise_beside_a_line_is_response_only_by_chance(structure):
    """Supposed modes in white noise under the leakage of a line: one in a hundred passes."""
    rng = np.random.default_rng(50)
    like = structure((9.0,), (0.02,), n_channels=3).simulate(rng, 60.0, 100.0)
    modes = identify_samples(like).modes
    mode, nothing = modes.modes[0], replace(modes, modes=())
    passed = n_tried = 0
    for seed in range(60):
        samples = replace(like, acceleration=sines(seed, 100.0, 60.0, (20.17,), -60.0, 3))
        evidence = LineEvidence.of(samples, (20.17,), nothing)
        for hz in (5.0, 8.0, 12.0, 16.0, 25.0, 30.0):
            passed += not evidence.explains(replace(mode, frequency_hz=hz))
            n_tried += 1
    assert passed <= 0.03 * n_tried, f'{passed} of {n_tried}'


@pytest.mark.parametrize('apart', [1.5, 40.0])
def test_sinusoids_are_fitted_to_rounding(apart):
    rng = np.random.default_rng(60)
    place = np.array([411.3, 411.3 + apart, 1502.8])
    phasor = rng.standard_normal((3, 4)) + 1j * rng.standard_normal((3, 4))
    phasor[0] *= 100.0
    wave = np.exp(2j * np.pi * np.outer(np.arange(6000) / 6000, place))
    rows = (wave @ phasor).real + 1.0
    fitted = fit_sinusoids(rows, 2.0 * np.pi * (place + np.array([0.06, -0.06, 0.05])) / 6000)
    left = fitted.taken_from(rows)
    assert np.std(left - left.mean(axis=0)) < 1e-9 * np.std(rows)


def wide_and_narrow(rng, rate_hz, n_rows):
    """Return rows of a wide mode, often with a narrow one in its bell, and the supposed modes."""
    at_hz, damping = rate_hz * rng.uniform(0.2, 0.38), rng.uniform(0.05, 0.12)
    pairs = [(at_hz, damping), (at_hz * rng.uniform(0.98, 1.02), 0.005)][: rng.integers(1, 3)]
    line_hz = np.fft.rfftfreq(n_rows, 1.0 / rate_hz)
    rows, modes = np.zeros((n_rows, 4)), []
    for hz, ratio in pairs:
        # Acceleration under a white force, behind a filter.
        bell = line_hz**2 / (hz**2 - line_hz**2 + 2j * ratio * hz * line_hz)
        force = rng.standard_normal(len(bell)) + 1j * rng.standard_normal(len(bell))
        motion = np.fft.irfft(force * bell * (line_hz < 0.45 * rate_hz), n_rows)
        shape = rng.standard_normal(4)
        rows += np.outer(motion / motion.std() * rng.uniform(0.5, 1.0), shape)
        modes.append(Mode(hz, ratio, shape.astype(complex)))
    return rows + 0.003 * rng.standard_normal(rows.shape), tuple(modes)


def test_a_wide_mode_is_no_line_for_a_narrow_one_in_its_bell_or_a_filter_beside_it(structure):
    like = structure((9.0,), (0.02,), n_channels=4).simulate(np.random.default_rng(0), 9.0, 100.0)
    for seed in range(400, 430):
        rows, modes = wide_and_narrow(np.random.default_rng(seed), 800.0, 12_000)
        samples = replace(like, acceleration=rows, sample_rate_hz=800.0)
        evidence = LineEvidence.of(samples, (), ModeSet(modes, like.channel_names))
        explained = [mode for mode in modes if evidence.explains(mode)]
        assert not explained, f'seed {seed}'
