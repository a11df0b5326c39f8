"""Many light modes side by side, as of a cable: few are taken for broader ones."""

from dataclasses import replace

import numpy as np

from oma_identifier.identify import identify_samples
from oma_identifier.identify_bands import band_sources
from oma_identifier.settings import IdentificationSettings

RATE_HZ, DURATION_S, DAMPING = 40.0, 240.0, 0.002
SETTINGS = IdentificationSettings(refine=False)
SEEDS = range(970300, 970304)


def cable(structure, n_modes, seed):
    """Return a cable with modes up to 0.4 of the rate, and its accelerations at eight places."""
    number = np.arange(1.0, n_modes + 1)
    stiff = number * np.sqrt(1.0 + 4e-4 * number**2)
    rng = np.random.default_rng(seed)
    place = rng.uniform(0.03, 0.97, 8)
    made = structure(0.4 * RATE_HZ * stiff / stiff[-1], np.full(n_modes, DAMPING))
    made = replace(made, shapes=np.sin(np.pi * np.outer(place, number)))
    return made, made.simulate(rng, DURATION_S, RATE_HZ)


def test_modes_of_a_cable_are_found_and_hardly_any_broader_ones(structure):
    n_asked = n_found = n_broad = 0
    for seed in SEEDS:
        made, samples = cable(structure, 30, seed)
        modes = identify_samples(samples, SETTINGS).modes
        asked_hz = made.frequency_hz[made.frequency_hz > 2.0]
        away_hz = np.abs(modes.frequency_hz[:, None] - asked_hz)
        n_asked += len(asked_hz)
        n_found += int(np.sum(away_hz.min(axis=0) < 3.0 * DAMPING * asked_hz))
        n_broad += int(np.sum(modes.damping_ratio > 4.0 * DAMPING))
    # 103 and none of 104; with the rows and order that few modes need 40, and 10 that are none.
    assert n_found > 0.95 * n_asked, f'{n_found} of {n_asked}, seeds {SEEDS}'
    assert n_broad == 0, f'{n_broad}, seeds {SEEDS}'


def test_only_a_band_of_many_modes_has_more_rows_and_orders(structure):
    for n_modes, rows, order in ((3, 20, 60), (16, 20, 60), (30, 40, 120)):
        _, samples = cable(structure, n_modes, SEEDS[0])
        top = band_sources([samples], SETTINGS)[0]
        assert top is not None
        assert (top.block_rows, top.max_order) == (rows, order)
        assert len(top.mean) == top.covariance.blocks.shape[1] == 2 * rows - 1


def test_rows_that_were_asked_for_stay(structure):
    _, samples = cable(structure, 30, SEEDS[0])
    top = band_sources([samples], replace(SETTINGS, block_rows=20))[0]
    assert top is not None
    assert (top.block_rows, top.max_order) == (20, 60)
