"""Ids along a motion."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.workspace_map.hidden_arms import hidden_arm, known_arm
from workspace_map import followed_from, WorkspaceMap
from workspace_map.rows import aligned

SEED = 101


@pytest.fixture(scope='module')
def known():
    arm = known_arm()
    return WorkspaceMap(arm, 60.0).with_measured(hidden_arm(SEED).measured(arm.model.pose('P1')))


def test_measured_modes_that_are_mixed_within_a_subspace_number_the_map_s():
    """Two modes nearer than their bands, mixed half and half: the ids go with what was measured.

    Both are turned by 45 degrees in a measurement; the same turn is what the map starts with.
    """
    nothing = WorkspaceMap(known_arm(), 60.0)
    q = nothing.arm.model.pose('P1')
    here = followed_from(nothing, q)
    close = replace(here.modes, squared=here.modes.squared.copy())
    close.squared[1] = 1.0002 * close.squared[0]
    mixed = close.channel_shapes[:, :2] @ np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2.0)
    measured = hidden_arm(SEED).measured(q)
    unit = mixed / np.linalg.norm(mixed, axis=0)
    turn = aligned(unit, close, np.array([0, 1])).turn
    assert np.abs(turn) == pytest.approx(np.full((2, 2), np.sqrt(0.5)), abs=0.1)
    assert list(followed_from(nothing, q, measured).ids[:2]) == [1, 2]


def test_an_undecided_id_is_not_stated(known):
    """Of two shapes that share a measured one nearly in halves, neither is sure."""
    q = known.arm.model.pose('P1')
    measured, here = hidden_arm(SEED).measured(q), followed_from(known, q)
    shapes = measured.shapes.copy()
    shapes[:, 0] += shapes[:, 1]
    shapes[:, 0] /= np.linalg.norm(shapes[:, 0])
    middle = measured.frequency_hz.copy()
    middle[0] = np.sqrt(middle[0] * middle[1])
    named = here.named(replace(measured, shapes=shapes, frequency_hz=middle))
    assert not named.sure[0]
    assert named.sure[3:].all()


def test_measured_modes_keep_their_ids_where_the_map_is_wrong(known):
    """4 % in one mode, many times its σ: the shape says which it is."""
    q = known.arm.model.pose('P1')
    measured = hidden_arm(SEED).measured(q)
    ids = followed_from(known, q).ids_of(measured)
    assert list(ids) == list(range(1, len(measured) + 1))
    wrong = measured.frequency_hz.copy()
    wrong[-1] *= 1.04
    assert list(followed_from(known, q).ids_of(replace(measured, frequency_hz=wrong))) == list(ids)
