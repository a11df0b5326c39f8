"""What a narrow-band force shakes is no mode, however well it is determined; modes stay modes.

Seeds as in the test; the force is independent of those that shake the mode.
"""

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.refinement import adopt_refined
from oma_identifier.refinement.acceptance import Outcome
from oma_identifier.refinement.refinement import refine

RATE_HZ, DURATION_S, N_CHANNELS = 64.0, 480.0, 4
MODE_HZ, PEAK_HZ, RATIO, WIDTH = 8.0, 11.0, 0.01, 0.015


def record(seed: int, *, ends: bool) -> tuple[Samples, ModeSet]:
    """Return responses of a mode and of a peak: another mode, or a band that ends."""
    rng = np.random.default_rng(seed)
    n_samples = round(DURATION_S * RATE_HZ)
    hz = np.fft.rfftfreq(n_samples, 1.0 / RATE_HZ)[:, None]
    natural_hz = np.array([MODE_HZ, PEAK_HZ])
    gain = hz**2 / (natural_hz**2 - hz**2 + 2j * RATIO * natural_hz * hz)
    if ends:
        band = np.exp(-0.25 * ((hz[:, 0] - PEAK_HZ) / (WIDTH * PEAK_HZ)) ** 2)
        gain[:, 1] = 0.5 * band / RATIO
    shapes = rng.standard_normal((N_CHANNELS, 2))
    modal = np.fft.rfft(rng.standard_normal((n_samples, 2)), axis=0)
    response = np.fft.irfft(gain * modal, n_samples, axis=0) @ shapes.T
    response += 2e-3 * response.std() * rng.standard_normal(response.shape)
    channels = tuple(Channel(name=f'c{number}') for number in range(N_CHANNELS))
    modes = tuple(
        Mode(
            float(place),
            RATIO,
            shape.astype(complex),
            frequency_std_hz=0.2 * float(place * RATIO),
            damping_ratio_std=0.2 * RATIO,
        )
        for place, shape in zip(natural_hz, shapes.T, strict=True)
    )
    return Samples(response, RATE_HZ, channels), ModeSet(
        modes, tuple(channel.name for channel in channels)
    )


@pytest.mark.parametrize('seed', [986901, 986902, 986903])
def test_a_band_that_ends_is_a_force_and_no_mode(seed):
    samples, modes = record(seed, ends=True)
    found = refine(samples, modes, is_whole=True)
    assert found.outcomes == (Outcome.REFINED, Outcome.NARROW_FORCE)
    (force,) = found.narrow
    assert force.frequency_hz == pytest.approx(PEAK_HZ, abs=WIDTH * PEAK_HZ)
    assert force.reach_hz == pytest.approx(2.0 * WIDTH * PEAK_HZ, rel=0.5)
    adopted = adopt_refined(samples, modes, ModeSet((), modes.channel_names))
    assert adopted.forced == (1,)
    (mode,) = adopted.modes
    assert mode.frequency_hz == pytest.approx(MODE_HZ, abs=4.0 * mode.frequency_std_hz)


@pytest.mark.parametrize('seed', [986901, 986902, 986903])
def test_a_mode_at_its_place_is_one(seed):
    samples, modes = record(seed, ends=False)
    found = refine(samples, modes, is_whole=True)
    assert found.outcomes == (Outcome.REFINED, Outcome.REFINED)
    assert not found.narrow
