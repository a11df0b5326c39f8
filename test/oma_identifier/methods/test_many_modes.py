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
