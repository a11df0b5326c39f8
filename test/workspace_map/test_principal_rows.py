"""Rows of shapes in their principal directions are derivatives of what is measured."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.workspace_map.hidden_arms import known_arm
from workspace_map.arm import local_modes, State
from workspace_map.prior import structure_of
from workspace_map.rows import aligned, principal_rows, ROWS

SEED = 4


@pytest.fixture(scope='module')
def arm():
    return known_arm()


def test_rows_are_slopes_of_unit_shapes(arm):
    """Central differences along a random direction; seed 4."""
    rng, none = np.random.default_rng(SEED), State.none(arm.n_dof, arm.n_masses)
    way = State(*(0.1 * rng.standard_normal(len(part)) for part in vars(none).values()))
    place = arm.at(arm.model.pose('P1'))
    modes = local_modes(place, none, 60.0)
    rows = principal_rows(arm, modes)

    def seen(part):
        shapes = local_modes(place, none.towards(way, part), 60.0).channel_shapes
        unit = shapes / np.linalg.norm(shapes, axis=0)
        return np.einsum('rkc,cr->rk', rows.turn, aligned(unit, modes, np.arange(modes.n)).shapes)

    expected = sum(
        part @ own for part, own in zip(rows.parts, structure_of(arm, way), strict=True)
    )
    assert expected.shape == (modes.n, ROWS)
    found = (seen(1e-5) - seen(-1e-5)) / 2e-5
    assert found == pytest.approx(expected, rel=1e-3, abs=1e-5)


def test_directions_are_orthonormal_and_leave_the_subspace(arm):
    """Also that of two modes nearer than their bands, where slopes have no first order."""
    place = arm.at(arm.model.pose('P1'))
    modes = local_modes(place, State.none(arm.n_dof, arm.n_masses), 60.0)
    squared = modes.squared.copy()
    squared[1] = 1.001 * squared[0]
    modes = replace(modes, squared=squared)
    turn = principal_rows(arm, modes).turn
    assert turn @ turn.transpose(0, 2, 1) == pytest.approx(np.tile(np.eye(ROWS), (modes.n, 1, 1)))
    unit = modes.channel_shapes / np.linalg.norm(modes.channel_shapes, axis=0)
    assert turn[:2] @ unit[:, :2] == pytest.approx(0.0, abs=1e-9)


def test_measured_shapes_are_turned_within_their_subspace_alone(arm):
    """Any mixture of two modes nearer than their bands comes back as the modes; seed 4."""
    place = arm.at(arm.model.pose('P1'))
    modes = local_modes(place, State.none(arm.n_dof, arm.n_masses), 60.0)
    squared = modes.squared.copy()
    squared[1] = 1.001 * squared[0]
    modes = replace(modes, squared=squared)
    shapes = modes.channel_shapes
    size = np.linalg.norm(shapes, axis=0)
    angle = 0.7
    mix = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    measured = -shapes
    measured[:, :2] = shapes[:, :2] @ mix
    found = aligned(measured / size, modes, np.arange(modes.n)).shapes
    assert found == pytest.approx(shapes / size, abs=1e-9)


def test_a_pose_without_modes_below_the_band_has_no_rows(arm):
    """A fit on its way may make an arm that stiff."""
    place, none = arm.at(arm.model.pose('P1')), State.none(arm.n_dof, arm.n_masses)
    rows = principal_rows(arm, local_modes(place, none, 1.0))
    assert len(rows.turn) == 0
    assert all(len(part) == 0 for part in rows.parts)
