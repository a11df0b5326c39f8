"""A steady line of a machine beside a mode, with every method that would bend for it."""

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.methods import identify_by

RATE_HZ, DURATION_S, LINE_HZ, FORCE = 128.0, 60.0, 20.25, 4.0
MODES = (20.0, 0.015), (33.0, 0.02)


def shaken_by_chance_and_a_line(seed: int) -> Samples:
    """Return responses to white forces and to a sinusoid of four times their size."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(RATE_HZ * DURATION_S)) / RATE_HZ
    line = np.exp(2j * np.pi * LINE_HZ / RATE_HZ)
    rows = np.zeros((len(time), 4))
    for hz, zeta in MODES:
        pole = np.exp(2.0 * np.pi * hz / RATE_HZ * complex(-zeta, np.sqrt(1.0 - zeta**2)))
        force = rng.standard_normal(len(time) + 2000)
        random = lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], force)[2000:]
        gain = FORCE / ((1.0 - pole / line) * (1.0 - pole.conj() / line))
        steady = np.real(gain * np.exp(2j * np.pi * LINE_HZ * time))
        rows += np.outer(random + steady, rng.standard_normal(4))
    rows += 0.01 * rows.std(axis=0) * rng.standard_normal(rows.shape)
    return Samples(rows, RATE_HZ, tuple(Channel(name) for name in 'abcd'))


@pytest.mark.parametrize('method', ['ssi_data', 'var', 'rvar', 'notch', 'vmd'])
@pytest.mark.parametrize('seed', [702_410, 702_411])
def test_a_mode_half_a_width_from_a_line_is_found_and_not_bent(method, seed):
    found = identify_by(method, shaken_by_chance_and_a_line(seed))
    assert len(found.modes) == len(MODES), f'seed {seed}'
    for mode, (hz, _) in zip(found.modes, MODES, strict=True):
        off_hz = mode.frequency_hz - hz
        assert abs(off_hz) < 3.0 * mode.frequency_std_hz, f'seed {seed}: {off_hz}'
    np.testing.assert_allclose(found.sure_lines_hz, [LINE_HZ], atol=1.0 / DURATION_S)
