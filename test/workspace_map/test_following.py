"""Ids along a motion."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.hidden_arms import hidden_arm, known_arm
from excitation_planner.mode_following import follow, modes_at
from structural_model.scan import random_poses
from workspace_map import followed_from, followed_ids, WorkspaceMap

SEED = 101


@pytest.fixture(scope='module')
def known():
    arm = known_arm()
    return WorkspaceMap(arm, 60.0).with_measured(hidden_arm(SEED).measured(arm.model.pose('P1')))


def test_modes_are_followed_as_the_planner_follows_them():
    """The planner's is another program; with nothing measured both know the model alone."""
    nothing = WorkspaceMap(known_arm(), 60.0)
    model = nothing.arm.model
    poses = random_poses(model.limits, 8, np.random.default_rng(SEED))
    for start, end in poses.reshape(4, 2, -1):
        expected = follow(model, modes_at(model, start, 60.0), start, end)
        here = followed_from(nothing, start).moved(end)
        for number, frequency_hz in zip(here.ids, here.modes.frequency_hz, strict=True):
            if number:
                true_hz = expected.frequency_hz[number - 1]
                assert frequency_hz == pytest.approx(true_hz, rel=1e-6)


def test_modes_that_change_places_keep_their_ids():
    """Two frequencies cross between neighbouring poses: shapes turn a little, columns change."""
    rng = np.random.default_rng(SEED)
    before = np.linalg.qr(rng.standard_normal((8, 8)))[0]
    turn = np.linalg.qr(np.eye(8) + 0.05 * rng.standard_normal((8, 8)))[0]
    after = (before @ turn)[:, [0, 2, 1, 3, 4, 5, 6, 7]]
    assert list(followed_ids(before, np.array([1, 2, 3]), after)) == [1, 3, 2, 0, 0, 0, 0, 0]


def test_measured_modes_keep_their_ids_where_the_map_is_wrong(known):
    """4 % in one mode, many times its σ: the shape says which it is."""
    q = known.arm.model.pose('P1')
    measured = hidden_arm(SEED).measured(q)
    ids = followed_from(known, q).ids_of(measured)
    assert list(ids) == list(range(1, len(measured) + 1))
    wrong = measured.frequency_hz.copy()
    wrong[-1] *= 1.04
    assert list(followed_from(known, q).ids_of(replace(measured, frequency_hz=wrong))) == list(ids)
