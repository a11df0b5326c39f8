"""A law takes over from its special case: where that is, and with what that has free."""

from dataclasses import replace

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.cell.cell_model import CellModel, HeldTorque
from model_gap.cell.tolerances import nuisances, Tolerances
from model_gap.effects import CATALOGUE, Scene
from model_gap.effects.coulomb_friction import CoulombFriction
from model_gap.effects.load_friction import LoadFriction
from model_gap.effects.payload import Payload
from model_gap.effects.stribeck_friction import StribeckFriction
from model_gap.hypothesis import Hypothesis, instead_of_tolerances, is_special_case, more_general
from model_gap.search.search import links_with_mass


@pytest.fixture
def scene(robot, layout):
    cell = CellModel(explicit_damping(robot.spec), layout.channels)
    return Scene(robot, tuple(sensor.name for sensor in layout), cell)


@pytest.mark.parametrize('details', [False, True])
def test_a_law_begins_where_its_special_case_is(scene, details):
    rubs = CoulombFriction('joint_2', details=details)
    values = (80.0, 1e-3, 0.04)[: 2 + details]
    held = (HeldTorque((), ()),)
    bare = Hypothesis(scene, (), (), np.zeros(0), np.zeros(0), held)
    starts = more_general(bare.with_effect(rubs, values), CATALOGUE)
    assert {item.effects[-1].type for item in starts} == {'stribeck_friction', 'load_friction'}
    for item in starts:
        assert item.held == held and item.effects[-1].location == 'joint_2'
        names = [number.name for number in item.parameters]
        assert ('presliding_compliance' in names) == details
        if details:
            assert item.values()[-1][-1] == pytest.approx(0.04)
    assert more_general(bare.with_effect(Payload('flange'), (5.0, 0, 0, 0, 0.1)), CATALOGUE) == []


def test_a_special_case_is_of_the_same_place():
    for law in (StribeckFriction, LoadFriction):
        assert is_special_case(CoulombFriction('joint_1'), law('joint_1'))
        assert not is_special_case(CoulombFriction('joint_1'), law('joint_2'))
        assert not is_special_case(law('joint_1'), CoulombFriction('joint_1'))
        assert not is_special_case(law('joint_1'), law('joint_1'))


def test_a_tool_of_the_model_that_is_too_heavy_may_be_a_payload(scene, robot):
    """A mass that is fixed to a link is that link's; other tolerances stay as they were."""
    tolerances = nuisances(scene.cell, links_with_mass(robot), Tolerances())
    before = Hypothesis(
        scene, tolerances, (), np.linspace(-1.0, 1.0, len(tolerances)), np.zeros(0)
    )
    values = before.tolerance_values.copy()
    values[[item.name for item in tolerances].index('mass of spindle')] = 6.0
    stretched = replace(before, tolerance_values=values)
    found = instead_of_tolerances(stretched, before, CATALOGUE)
    assert {item.effects[-1].key for item in found} == {('payload', robot.link_names[-1])}
    for item in found:
        np.testing.assert_array_equal(item.tolerance_values, before.tolerance_values)
