"""The size of what levels have is that of the identified modes, their changes that of motions."""

import math

import numpy as np
import pytest

from oma_identifier.levels import ModalMotion, stiffness_at_levels

HZ, ZETA, SEED = 10.0, 0.02, 79500


def levels(rng, factor, added=(0.0, 0.0, 0.0), own=2e-3, beside=1e-3):
    """Return motions whose moments are off by a factor; frequencies scatter with them."""
    found = []
    for move_m, more in zip((1e-4, 3e-4, 1e-3), added, strict=True):
        stiffness = (2.0 * math.pi * HZ) ** 2 * (1.0 + more)
        alike, alone = own * rng.standard_normal(), beside * rng.standard_normal()
        hz = math.sqrt(stiffness * (1.0 + alike)) / (2.0 * math.pi)
        moment = stiffness * factor * (1.0 + alike + alone)
        std, hz_std = math.hypot(own, beside) * moment, 0.5 * own * hz
        found.append(
            ModalMotion(
                move_m, 60.0 * move_m, 3.0 * move_m**2, 1e4 * move_m**2, 0.1, moment, std, 0.0, (),
                1.0, HZ, 0.0, frequency_hz=hz, frequency_std_hz=hz_std, damping_ratio=ZETA,
            )
        )  # fmt: skip
    return found


@pytest.mark.parametrize('factor', [0.99, 1.0, 1.015])
def test_what_all_levels_have_in_common_is_no_part_of_the_stiffness(factor):
    """Of 600 draws 93 to 97 of 100 levels within two deviations, and so their changes."""
    rng = np.random.default_rng(SEED)
    truth, added = (2.0 * math.pi * HZ) ** 2, np.array([0.0, 0.005, 0.05])
    off, changes = [], []
    for _ in range(600):
        found = stiffness_at_levels(levels(rng, factor, added))
        off += ((found.value - truth * (1.0 + added)) / found.std).tolist()
        spread = found.covariance[2, 2] + found.covariance[0, 0] - 2.0 * found.covariance[2, 0]
        change = found.value[2] - found.value[0] - truth * 0.05
        changes.append(change / math.sqrt(spread))
        assert found.told
    share, of_changes = (np.mean(np.abs(each) < 2.0) for each in (off, changes))
    said = f'seed {SEED}: {share:.3f}, changes {of_changes:.3f}'
    assert share > 0.93, said
    assert of_changes > 0.93, said


def test_what_is_far_off_the_frequency_is_other_modes_and_has_no_deviation():
    """Six tenths of a half-width."""
    found = stiffness_at_levels(levels(np.random.default_rng(SEED), 1.0 - 1.2 * ZETA))
    assert found.off == pytest.approx(0.6, abs=0.1)
    assert not found.told and np.isnan(found.std).all()


def test_without_a_deviation_of_the_frequency_there_is_none_of_the_stiffness():
    found = stiffness_at_levels(
        [
            ModalMotion(1e-3, 0.06, 3e-6, 0.01, 0.1, 4e3, 10.0, 0.0, (), 1.0, HZ, 0.0)
            for _ in range(3)
        ]
    )
    assert np.isnan(found.std).all() and found.value == pytest.approx(4e3)
