"""Frequency domain decomposition of a structure with more modes than principal coordinates."""

import numpy as np

from benchmarks.identifier.plant import Plant, simulate
from modal_core.numbers.indicators import mac
from oma_identifier.methods.fdd import efdd, fdd
from oma_identifier.methods.thresholds import METHOD


def test_shapes_are_those_of_all_channels():
    """Twenty-four modes in 30 channels, half-widths of 1 %, neighbours 12 % apart."""
    n_modes = 2 * METHOD.most_coordinates
    for seed in (993910, 993911):
        generator = np.random.default_rng(seed)
        plant = Plant(
            frequency_hz=4.0 * 1.12 ** np.arange(n_modes),
            damping_ratio=np.full(n_modes, 0.01),
            shapes=generator.standard_normal((30, n_modes)),
            participation=generator.standard_normal((n_modes, n_modes)),
        )
        record = simulate(plant, generator, 120.0, 160.0)
        for found in (fdd(record), efdd(record)):
            right = [
                float(mac(mode.shape, plant.shapes).max())
                for mode in found
                if np.abs(mode.frequency_hz / plant.frequency_hz - 1.0).min() < 0.02
            ]
            assert len(right) >= n_modes - 4, f'seed {seed}: {found.frequency_hz}'
            assert min(right) > 0.95, f'seed {seed}: {right}'


def test_a_bell_that_is_not_described_with_those_beside_it_has_no_deviation():
    """Nine modes, some of whose bells overlap, in ten channels."""
    errors, n_unknown = [], 0
    for seed in range(993920, 993926):
        generator = np.random.default_rng(seed)
        plant = Plant(
            frequency_hz=3.0 * 1.3 ** np.arange(9) * generator.uniform(0.9, 1.1, 9),
            damping_ratio=generator.uniform(0.005, 0.03, 9),
            shapes=generator.standard_normal((10, 9)),
            participation=generator.standard_normal((9, 6)),
        )
        for mode in efdd(simulate(plant, generator, 60.0, 100.0)):
            off = mode.frequency_hz - plant.frequency_hz
            nearest = off[np.abs(off).argmin()]
            n_unknown += int(np.isnan(mode.frequency_std_hz))
            assert np.isnan(mode.frequency_std_hz) == np.isnan(mode.damping_ratio_std)
            errors.append(nearest / mode.frequency_std_hz)
    stated = np.array(errors)[np.isfinite(errors)]
    assert n_unknown > 0
    assert len(stated) > 0
    assert np.sqrt(np.mean(stated**2)) < 2.0, f'seeds 993920..993925: {stated}'
