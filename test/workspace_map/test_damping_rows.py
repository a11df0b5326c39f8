"""Rows of damping: unbiased where a record tells it poorly."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.workspace_map.hidden_arms import hidden_arm, known_arm
from workspace_map.arm import local_modes, State
from workspace_map.rows import damping_block

RELATIVE_STD, DRAWS = 0.25, 400


@pytest.fixture(scope='module')
def expected():
    arm = known_arm()
    q = arm.model.pose('P1')
    modes = local_modes(arm.at(q), State.none(arm.n_dof, arm.n_masses), 60.0)
    return arm, modes, hidden_arm(101).measured(q)


def block(expected, ratio, std):
    arm, modes, measured = expected
    first = np.arange(len(ratio))
    pose = replace(
        measured,
        frequency_hz=measured.frequency_hz[first],
        frequency_std_hz=measured.frequency_std_hz[first],
        damping_ratio=ratio,
        damping_ratio_std=std,
        shapes=measured.shapes[:, first],
        shape_std=measured.shape_std[:, first],
    )
    return damping_block(arm, modes, pose, (first, first))


def test_noise_of_damping_makes_it_neither_higher_nor_lower(expected):
    """400 draws of three modes, 25 %; weighted as the regression does."""
    true = expected[1].damping_ratio[:3]
    generator = np.random.default_rng(5)
    sums = np.zeros(2)
    for _ in range(DRAWS):
        ratio = true * (1.0 + RELATIVE_STD * generator.standard_normal(3))
        found = block(expected, ratio, RELATIVE_STD * true)
        sums += np.sum(found.residual / found.std**2), np.sum(found.std**-2)
    assert abs(sums[0] / sums[1]) < 3.0 * RELATIVE_STD / np.sqrt(3 * DRAWS)


def test_what_is_not_known_is_no_row(expected):
    true = expected[1].damping_ratio[:3]
    known = block(expected, true * [1.0, np.nan, 1.0], true * [0.1, 0.1, np.nan])
    assert known.residual == pytest.approx([0.0])
    assert known.std == pytest.approx([0.1])
