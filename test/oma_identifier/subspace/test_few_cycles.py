"""Damping of modes of which a record shows few cycles: no bias, and a deviation that holds."""

import numpy as np
from scipy.signal import lfilter

from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.settings import IdentificationSettings

RATE_HZ, FREQUENCY_HZ, DAMPING, DURATION_S = 20.0, 4.0, 0.01, 60.0
N_RECORDS = 80


def record(seed: int) -> Samples:
    """Return two channels that one mode moves; ζ f T is 2.4."""
    generator = np.random.default_rng(seed)
    omega = 2 * np.pi * FREQUENCY_HZ
    pole = np.exp(omega * (-DAMPING + 1j * np.sqrt(1 - DAMPING**2)) / RATE_HZ)
    before, n_samples = 2000, int(DURATION_S * RATE_HZ)
    force = generator.standard_normal(before + n_samples)
    modal = lfilter([1.0, -2.0, 1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], force)[before:]
    clean = np.outer(modal, [1.0, 0.6])
    noise = 0.02 * clean.std() * generator.standard_normal(clean.shape)
    return Samples(clean + noise, RATE_HZ, (Channel('upper'), Channel('lower')))


def test_damping_of_few_cycles_is_not_biased_upwards():
    settings = IdentificationSettings(refine=False)
    errors, surprises = [], []
    for seed in range(N_RECORDS):
        for mode in identify_samples(record(seed), settings).modes:
            if abs(mode.frequency_hz / FREQUENCY_HZ - 1.0) < 0.02:
                error = mode.damping_ratio - DAMPING
                errors.append(2 * np.pi * FREQUENCY_HZ * DURATION_S * error)
                surprises.append(error / mode.damping_ratio_std)
    surprises = np.array(surprises)[np.isfinite(surprises)]
    # In units of one over the length: there a half-width scatters by sqrt(2π ζ f T) = 3.9.
    assert len(errors) > 0.9 * N_RECORDS
    assert abs(np.mean(errors)) < 2.0 * np.std(errors) / np.sqrt(len(errors))
    assert 0.9 < np.mean(np.abs(surprises) < 2.0) < 0.995
