"""Modes above the highest frequency asked for reach below it."""

import numpy as np

from benchmarks.identifier.plant import chain_plant, simulate
from oma_identifier.identify import identify_samples
from oma_identifier.settings import IdentificationSettings

SEED, HIGHEST_HZ = 5, 28.0


def test_strong_modes_just_above_the_band_do_not_stop_the_refinement_below():
    plant = chain_plant(6, 110.0)
    samples = simulate(plant, np.random.default_rng(SEED), 120.0, 256.0)
    assert np.any((plant.frequency_hz > HIGHEST_HZ) & (plant.frequency_hz < 2.0 * HIGHEST_HZ))
    found = identify_samples(samples, IdentificationSettings(max_frequency_hz=HIGHEST_HZ))
    inside = plant.frequency_hz[plant.frequency_hz < HIGHEST_HZ]
    np.testing.assert_allclose(found.modes.frequency_hz, inside, rtol=0.01)
    assert found.poles.frequency_hz.max() <= HIGHEST_HZ
    refined = [mode.shape_std is not None for mode in found.modes]
    assert all(refined), f'seed {SEED}: {refined}'
