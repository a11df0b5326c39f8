"""Lines taken out of samples: what is left, and what it does for the modes beside them."""

from dataclasses import replace

import numpy as np

from modal_core.samples import Samples
from oma_identifier.covariance.bands import plan_bands
from oma_identifier.covariance.condition import BandConditioner
from oma_identifier.identify import identify_samples
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra.harmonics import line_at, N_SEGMENTS
from oma_identifier.spectra.line_removal import without_lines


def waves(samples: Samples, *lines: tuple[float, float]) -> np.ndarray:
    time = np.arange(len(samples.acceleration)) / samples.sample_rate_hz
    shape = np.linspace(-1.0, 1.5, samples.acceleration.shape[1])
    total = sum(size * np.sin(2.0 * np.pi * hz * time + hz) for hz, size in lines)
    return np.outer(total, shape)


def test_only_the_lines_go(structure):
    samples = structure((6.0, 14.0), (0.02, 0.02)).simulate(np.random.default_rng(1), 60.0, 100.0)
    added = waves(samples, (9.137, 0.7), (19.4, 0.5))
    mixed = replace(samples, acceleration=samples.acceleration + added)
    # Found to half of one over the duration, as a line is.
    left = without_lines(mixed, (9.137 + 0.4 / 60.0, 19.4 - 0.4 / 60.0)).acceleration
    assert np.std(left - samples.acceleration) < 0.1 * np.std(added)
    # At 9.137 Hz nothing else moves: what is left there is a hundredth.
    time = np.arange(len(left)) / 100.0
    probe = np.exp(-2j * np.pi * 9.137 * time)
    assert np.abs(probe @ left).max() < 0.02 * np.abs(probe @ mixed.acceleration).max()
    assert without_lines(mixed, ()) is mixed


def test_a_line_far_above_the_response_goes_to_below_it(structure):
    samples = structure((6.0, 14.0), (0.02, 0.02)).simulate(np.random.default_rng(1), 60.0, 100.0)
    # 40 dB above the response of all modes: what is off by a hundredth of one over the duration
    # would leave as much as there is.
    lines = [(9.137, 300.0), (14.281, 200.0)]
    mixed = replace(samples, acceleration=samples.acceleration + waves(samples, *lines))
    left = without_lines(mixed, [hz + 0.4125 / 60.0 for hz, _ in lines]).acceleration
    assert np.std(left - samples.acceleration) < 0.2 * np.std(samples.acceleration)


def test_a_line_is_found_where_it_is_and_not_where_it_is_seen_from(structure):
    samples = structure((6.0,), (0.02,)).simulate(np.random.default_rng(3), 60.0, 100.0)
    mixed = replace(samples, acceleration=samples.acceleration + waves(samples, (20.31, 0.5)))
    for images in (-2, -1, 0, 1, 2):
        line = line_at(mixed, 20.31 + images * N_SEGMENTS / 60.0)
        assert abs(line.frequency_hz - 20.31) < 0.5 / 60.0, images
        assert line.chance < 1e-6


def test_a_mode_beside_a_line_is_not_biased_by_it(structure):
    known = structure((9.0, 20.0), (0.02, 0.02))
    settings = IdentificationSettings(refine=True)
    errors = []
    for seed in range(20, 26):
        clean = known.simulate(np.random.default_rng(seed), 60.0, 100.0)
        mixed = replace(clean, acceleration=clean.acceleration + waves(clean, (20.3, 1.5)))
        result = identify_samples(mixed, settings)
        assert len(result.modes) == 2, f'seed {seed}: {result.modes.frequency_hz}'
        assert len(result.harmonics) == 1, f'seed {seed}'
        mode = result.modes.modes[1]
        errors.append((mode.frequency_hz - 20.0) / mode.frequency_std_hz)
        errors.append((mode.damping_ratio - 0.02) / mode.damping_ratio_std)
    assert np.sqrt(np.mean(np.square(errors))) < 2.0, errors


def test_nothing_is_left_of_a_line_in_a_band_that_does_not_see_it():
    bands = plan_bands(256.0, 240.0, IdentificationSettings())
    time = np.arange(240 * 256) / 256.0
    lines_hz = np.array([0.3, 1.0, 3.0, 7.0, 12.0, 25.0, 50.0, 100.0])
    rows = np.sin(2.0 * np.pi * np.outer(time, lines_hz))
    assert len(bands) > 2
    for band in bands:
        seen = band.sees(lines_hz)
        passed = BandConditioner(band).condition(rows)
        settled = passed[len(passed) // 2 :].std(axis=0)
        assert np.all(settled[~seen] < 0.005), (band, settled)
        assert not seen.all() and seen.any()
        assert seen[(lines_hz >= band.low_hz) & (lines_hz <= band.high_hz)].all()
