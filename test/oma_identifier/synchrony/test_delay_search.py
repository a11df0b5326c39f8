"""What is left out of the comparison of sensors does not count."""

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.synchrony.delay_likelihood import DelayLikelihood
from oma_identifier.synchrony.peak_view import view_at
from oma_identifier.synchrony.sensor_peaks import sensor_peaks
from oma_identifier.synchrony.thresholds import SYNCHRONY

SEED = 41_300
RATE_HZ = 200.0
OWN = [np.arange(first, first + 3) for first in (3, 6, 9)]
BESIDE = np.arange(3)


@pytest.fixture
def peaks(structure):
    """Return a function that gives the peaks of a record whose third sensor is late."""

    def make(delay_rows):
        plant = structure((8.3, 13.1, 21.7, 33.9, 52.2), (0.012, 0.02, 0.008, 0.015, 0.01), 12)
        rows = plant.simulate(np.random.default_rng(SEED), 60.0, RATE_HZ, 0.02).acceleration
        rows[:, 6:9] = np.roll(rows[:, 6:9], delay_rows, axis=0)
        return sensor_peaks(Samples(rows, RATE_HZ, tuple(Channel(f'c{n}') for n in range(12))))

    return make


@pytest.mark.parametrize('delay_rows', [0, 4])
def test_delays_that_are_given_up_are_unlikely(peaks, delay_rows):
    found = peaks(delay_rows)
    views = [view_at(peak, peak.spectra, OWN, BESIDE, np.ones(3), 1.0) for peak in found]
    likelihood = DelayLikelihood(views)
    delay_s = np.tile(np.arange(-SYNCHRONY.latest_s, SYNCHRONY.latest_s, 2.5e-4), 3)
    sensor = np.repeat(np.arange(3), len(delay_s) // 3)
    every = likelihood.of(sensor, delay_s, np.zeros(3))
    best = every.reshape(3, -1).argmax(axis=1)
    np.testing.assert_allclose(delay_s[best], [0.0, delay_rows / RATE_HZ, 0.0], atol=1e-3)
    least = 1e-8 * every.reshape(3, -1).max(axis=1)
    some = likelihood.of(sensor, delay_s, least)
    likely = every >= least[sensor]
    assert 0 < likely.sum() < 0.1 * len(likely), f'seed {SEED}'
    np.testing.assert_allclose(some[likely], every[likely], rtol=1e-6)
    assert (some[~likely] <= 1.001 * every[~likely]).all()
    low_s, high_s = delay_s - 1e-3, delay_s + 1e-3
    assert (likelihood.within(sensor, low_s, high_s) >= 0.999 * every).all()
