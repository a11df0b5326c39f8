"""Lightly damped modes that still ring when the next tap comes, and peaks that are left over."""

import numpy as np
import pytest

from impact_testing import impact_modes
from impact_testing.unexplained import unexplained_peaks
from test.support.hammer_bench import even_chain, taps

SEED = 41
N = 5
TRUE_HZ = np.sqrt(4e4) / np.pi * np.sin((2 * np.arange(1, N + 1) - 1) * np.pi / (4 * N + 2))
MASS_KG = float(10.0 * (2 * N + 1) / 4 / np.cos(np.pi / (4 * N + 2)) ** 2)


@pytest.mark.parametrize('seed', [SEED, SEED + 1])
def test_modes_of_a_tenth_of_a_percent_are_right_with_taps_two_seconds_apart(seed):
    """The weights of neighbouring summits had said of one mode of each that it was not there."""
    print('seed', seed)
    rng, structure = np.random.default_rng(seed), even_chain(damping=0.001)
    times = 1.0 + 2.0 * np.arange(6) + rng.uniform(0.0, 0.002, 6)
    record = taps(
        structure, 4, times, rng, last_s=2.0, width_s=0.004, noise=0.01, force_noise_n=0.05
    )
    found = impact_modes([record])
    assert found.modes.frequency_hz == pytest.approx(TRUE_HZ, rel=5e-5)
    assert found.modes.damping_ratio == pytest.approx(0.001, rel=0.03)
    masses = [each.modal_mass_kg for each in found.scaled_modes]
    assert masses == pytest.approx([MASS_KG] * N, rel=0.01)
    assert not any('not explained' in remark for remark in found.remarks)


@pytest.mark.parametrize('missing', range(N))
def test_the_peak_of_a_mode_that_is_missing_is_told(missing):
    rng, structure = np.random.default_rng(SEED), even_chain()
    times = 0.5 + 3.0 * np.arange(4)
    (point,) = impact_modes([taps(structure, 4, times, rng, last_s=3.0, noise=0.01)]).points
    poles, _ = structure.modes()
    assert unexplained_peaks([point.data], poles) == ()
    (peak,) = unexplained_peaks([point.data], np.delete(poles, missing))
    assert peak == pytest.approx(TRUE_HZ[missing], abs=0.5)
