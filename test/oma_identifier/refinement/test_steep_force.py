"""A force that ends within the band must not make modes wrong, neither behind its end nor before.

Seeds as in the test; deviations are those that the refinement itself states.
"""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.refinement.acceptance import Outcome
from oma_identifier.refinement.refinement import refine

RATE_HZ, OVER, DURATION_S, CORNER_HZ = 128.0, 4, 120.0, 30.0
FREQUENCY_HZ = np.array([8.0, 11.0, 16.0, 36.0])
RATIO = np.full(4, 0.02)
N_CHANNELS = 5


def record(seed: int) -> tuple[Samples, ModeSet]:
    """Return responses to a force behind a low-pass filter of order eight, and the true modes."""
    rng = np.random.default_rng(seed)
    rate = OVER * RATE_HZ
    n_samples = round(DURATION_S * rate)
    low_pass = butter(8, CORNER_HZ, fs=rate, output='sos')
    force = sosfilt(low_pass, rng.standard_normal((2 * n_samples, 4)), axis=0)[n_samples:]
    shapes = rng.standard_normal((N_CHANNELS, 4))
    hz = np.fft.rfftfreq(n_samples, 1.0 / rate)[:, None]
    gain = hz**2 / (FREQUENCY_HZ**2 - hz**2 + 2j * RATIO * FREQUENCY_HZ * hz)
    modal = np.fft.rfft(force, axis=0) @ rng.standard_normal((4, 4))
    response = np.fft.irfft(gain * modal, n_samples, axis=0)[::OVER] @ shapes.T
    response += 2e-2 * response.std() * rng.standard_normal(response.shape)
    channels = tuple(Channel(name=f'c{number}') for number in range(N_CHANNELS))
    modes = tuple(
        Mode(
            float(hz),
            float(ratio),
            shape.astype(complex),
            frequency_std_hz=0.2 * float(hz * ratio),
            damping_ratio_std=0.2 * float(ratio),
        )
        for hz, ratio, shape in zip(FREQUENCY_HZ, RATIO, shapes.T, strict=True)
    )
    names = tuple(channel.name for channel in channels)
    return Samples(response, RATE_HZ, channels), ModeSet(modes, names)


@pytest.mark.parametrize('seed', [961101, 961102, 961103])
def test_modes_before_the_end_hold_and_those_behind_it_are_left_as_they_are(seed):
    samples, modes = record(seed)
    found = refine(samples, modes, is_whole=True)
    assert found.outcomes[-1] is Outcome.MODEL_MISFIT
    before = zip(found.modes.modes[:-1], FREQUENCY_HZ, strict=False)
    away = [(mode.frequency_hz - hz) / mode.frequency_std_hz for mode, hz in before]
    assert np.max(np.abs(away)) < 3.5
