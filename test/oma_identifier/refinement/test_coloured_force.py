"""A force behind a filter of first order has no one slope over bells as wide as these."""

import numpy as np
from scipy.signal import butter, lfilter
from scipy.stats import chi2

from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.refinement.acceptance import Outcome
from oma_identifier.refinement.refinement import refine

RATE_HZ, OVER, DURATION_S = 100.0, 4, 240.0
FREQUENCY_HZ = np.array([6.0, 10.0, 15.0, 22.0])
RATIO = np.array([0.06, 0.07, 0.05, 0.06])
N_CHANNELS = 5
SEEDS = range(961200, 961212)
BY_CHANCE = 1e-3


def record(seed: int) -> tuple[Samples, ModeSet]:
    """Return responses to forces behind a low-pass filter of first order, and the true modes."""
    rng = np.random.default_rng(seed)
    rate = OVER * RATE_HZ
    n_samples = round(DURATION_S * rate)
    filtered = butter(1, rng.uniform(6.0, 15.0), fs=rate)
    force = lfilter(*filtered, rng.standard_normal((2 * n_samples, 4)), axis=0)[n_samples:]
    shapes = rng.standard_normal((N_CHANNELS, 4))
    hz = np.fft.rfftfreq(n_samples, 1.0 / rate)[:, None]
    gain = hz**2 / (FREQUENCY_HZ**2 - hz**2 + 2j * RATIO * FREQUENCY_HZ * hz)
    modal = np.fft.rfft(force, axis=0) @ rng.standard_normal((4, 4))
    n_kept = n_samples // OVER
    below = (gain * modal)[: n_kept // 2 + 1]  # an ideal filter against aliasing
    response = np.fft.irfft(below, n_kept, axis=0) @ shapes.T / OVER
    response += 2e-2 * response.std() * rng.standard_normal(response.shape)
    channels = tuple(Channel(name=f'c{number}') for number in range(N_CHANNELS))
    modes = tuple(
        Mode(
            float(hz),
            float(ratio),
            shape.astype(complex),
            frequency_std_hz=0.1 * float(hz * ratio),
            damping_ratio_std=0.1 * float(ratio),
        )
        for hz, ratio, shape in zip(FREQUENCY_HZ, RATIO, shapes.T, strict=True)
    )
    return Samples(response, RATE_HZ, channels), ModeSet(modes, tuple(c.name for c in channels))


def test_what_is_refined_scatters_as_it_says():
    away = []
    for seed in SEEDS:
        found = refine(*record(seed), is_whole=True)
        for mode, outcome, hz, ratio in zip(
            found.modes, found.outcomes, FREQUENCY_HZ, RATIO, strict=True
        ):
            if outcome is Outcome.REFINED:
                away += [
                    (mode.frequency_hz - hz) / mode.frequency_std_hz,
                    (mode.damping_ratio - ratio) / mode.damping_ratio_std,
                ]
    assert len(away) > 1.6 * len(FREQUENCY_HZ) * len(SEEDS), SEEDS
    assert np.square(away).sum() < chi2.isf(BY_CHANCE, len(away)), f'{SEEDS}: {np.round(away, 1)}'
