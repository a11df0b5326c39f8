"""A steady line of a machine beside a mode, with every method that would bend for it."""

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.methods import identify_by

RATE_HZ, DURATION_S, LINE_HZ = 128.0, 60.0, 20.25
MODES = (20.0, 0.015), (33.0, 0.02)


def shaken_by_chance_and_a_line(seed: int, force_ratio: float) -> Samples:
    """Return responses to white forces of unit size and to a sinusoid."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(RATE_HZ * DURATION_S)) / RATE_HZ
    line = np.exp(2j * np.pi * LINE_HZ / RATE_HZ)
    rows = np.zeros((len(time), 4))
    for hz, zeta in MODES:
        pole = np.exp(2.0 * np.pi * hz / RATE_HZ * complex(-zeta, np.sqrt(1.0 - zeta**2)))
        force = rng.standard_normal(len(time) + 2000)
        random = lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], force)[2000:]
        gain = force_ratio / ((1.0 - pole / line) * (1.0 - pole.conj() / line))
        steady = np.real(gain * np.exp(2j * np.pi * LINE_HZ * time))
        rows += np.outer(random + steady, rng.standard_normal(4))
    rows += 0.01 * rows.std(axis=0) * rng.standard_normal(rows.shape)
    return Samples(rows, RATE_HZ, tuple(Channel(name) for name in 'abcd'))


@pytest.mark.parametrize('method', ['ssi_data', 'var', 'rvar', 'notch', 'vmd'])
@pytest.mark.parametrize('seed', [702_410, 702_411])
def test_a_mode_half_a_width_from_a_line_is_found_and_not_bent(method, seed):
    found = identify_by(method, shaken_by_chance_and_a_line(seed, 4.0))
    assert len(found.modes) == len(MODES), f'seed {seed}'
    for mode, (hz, _) in zip(found.modes, MODES, strict=True):
        off_hz = mode.frequency_hz - hz
        assert abs(off_hz) < 3.0 * mode.frequency_std_hz, f'seed {seed}: {off_hz}'
    np.testing.assert_allclose(found.sure_lines_hz, [LINE_HZ], atol=1.0 / DURATION_S)


@pytest.mark.parametrize('method', ['ssi_cov', 'ssi_data'])
@pytest.mark.parametrize('seed', range(702_420, 702_423))
def test_a_line_stronger_than_the_mode_in_whose_bell_it_is_is_seen(method, seed):
    """It stands 18 dB out of the bell, which hides how narrow it is, with twice its power."""
    found = identify_by(method, shaken_by_chance_and_a_line(seed, 0.25))
    np.testing.assert_allclose(found.sure_lines_hz, [LINE_HZ], atol=1.0 / DURATION_S)
    for mode, (hz, zeta) in zip(found.modes, MODES, strict=True):
        assert abs(mode.frequency_hz - hz) < 3.0 * mode.frequency_std_hz, f'seed {seed}'
        assert abs(mode.damping_ratio - zeta) < 3.5 * mode.damping_ratio_std, f'seed {seed}'
