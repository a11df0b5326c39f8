"""The map of one arm as the beginning of another's."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.workspace_map.hidden_arms import hidden_arm, known_arm, ROBOT
from benchmarks.workspace_map.tool import tools, with_tool
from modal_core.errors import MapError
from structural_model import load_layout
from structural_model.equations import random_poses
from workspace_map import load_map, load_other_map, save_map, WorkspaceMap

SEED = 33


def mapped(hidden, n_poses, before=None, arm=None):
    arm = arm or known_arm()
    poses = random_poses(arm.model.limits, n_poses, np.random.default_rng(SEED))
    measured = tuple(hidden.measured(q, number) for number, q in enumerate(poses))
    return WorkspaceMap(arm, 60.0, measured, before=before)


def median_error(known, hidden):
    off = []
    for q in random_poses(known.arm.model.limits, 30, np.random.default_rng(SEED + 1)):
        true, found = hidden.modes(q)[0], known.predict(q).frequency_hz
        n = min(len(true), len(found))
        off += list(np.abs(np.log(found[:n] / true[:n])))
    return np.median(off)


@pytest.fixture(scope='module')
def first():
    return mapped(hidden_arm(SEED), 8)


@pytest.mark.slow
def test_three_poses_of_an_arm_of_the_same_make_are_enough(first):
    """Seed 33: the same lack of the model, other tolerances."""
    other = hidden_arm(SEED, sibling=1)
    helped = mapped(other, 3, first)
    assert helped.worth_of_transfer() > 0.0
    assert median_error(helped, other) < 0.01
    assert median_error(helped, other) < 1.3 * median_error(mapped(other, 8), other) + 1e-3


@pytest.mark.slow
def test_an_arm_of_another_make_is_told(first):
    """Seed 35: what it has and its model lacks is something else."""
    assert mapped(hidden_arm(SEED + 2), 3, first).worth_of_transfer() < 0.0


def test_what_the_other_map_does_not_know_is_part_of_sigma(first):
    """Seed 33; 95 % are expected, of some hundred modes that hang together."""
    other = hidden_arm(SEED, sibling=1)
    helped, inside = mapped(other, 3, first), []
    for q in random_poses(helped.arm.model.limits, 30, np.random.default_rng(SEED + 2)):
        true, found = other.modes(q)[0], helped.predict(q)
        n = min(len(true), len(found))
        off = np.abs(found.frequency_hz[:n] - true[:n])
        inside += list(off < 2.0 * found.frequency_std_hz[:n])
    assert np.mean(inside) > 0.85


@pytest.mark.slow
def test_a_file_holds_the_other_map_too(first, tmp_path):
    """Without it the difference of the two arms would be taken for that from the model."""
    helped, layout = mapped(hidden_arm(SEED, sibling=1), 3, first), load_layout(ROBOT)
    save_map(tmp_path / 'map.json', helped, layout)
    again, _ = load_map(tmp_path / 'map.json', helped.arm.model, layout)
    q = helped.arm.model.pose('P2')
    expected, found = helped.predict(q), again.predict(q)
    assert found.frequency_hz == pytest.approx(expected.frequency_hz, rel=1e-9)
    assert found.covariance == pytest.approx(expected.covariance, rel=1e-6, abs=1e-12)
    assert again.worth_of_transfer() == pytest.approx(helped.worth_of_transfer(), rel=1e-6)


@pytest.fixture(scope='module')
def with_another_tool(first):
    """The first arm with another tool, three poses of it, and what it truly is; seed 33."""
    known, real = tools(SEED)
    hidden = hidden_arm(SEED)
    hidden = replace(hidden, model=with_tool(hidden.model, real), seed=SEED + 1)
    return mapped(hidden, 3, first, known), hidden


@pytest.mark.slow
def test_with_another_tool_what_the_arm_has_is_known_and_what_the_tool_has_is_not(
    first, with_another_tool
):
    helped, hidden = with_another_tool
    assert not helped.same_tool
    q = helped.arm.model.pose('P2')
    unmeasured = replace(helped, measured=()).state(q)
    assert unmeasured.spring == pytest.approx(first.state(q).spring)
    assert not unmeasured.without(10).mass[:10].any()
    assert unmeasured.mass[:10] == pytest.approx(0.0)
    error = median_error(helped, hidden)
    assert error < 0.01
    assert error < median_error(mapped(hidden, 3, None, helped.arm), hidden)


def test_a_file_tells_the_tool_of_the_map_it_began_with(first, with_another_tool, tmp_path):
    helped, layout = with_another_tool[0], load_layout(ROBOT)
    model = helped.arm.model
    save_map(tmp_path / 'first.json', first, layout)
    save_map(tmp_path / 'second.json', helped, layout)
    other = load_other_map(tmp_path / 'first.json', model, layout)
    assert (other.arm.tool, other.arm.model.spec.masses) == (
        first.arm.tool,
        first.arm.model.spec.masses,
    )
    again, _ = load_map(tmp_path / 'second.json', model, layout)
    q = model.pose('P2')
    expected, found = helped.predict(q), again.predict(q)
    assert found.frequency_hz == pytest.approx(expected.frequency_hz, rel=1e-9)
    assert found.covariance == pytest.approx(expected.covariance, rel=1e-6, abs=1e-12)
    softer = model.with_parameters({'joints.joint_2.drive.spring.stiffness': 2e6})
    with pytest.raises(MapError, match=r'another model of the robot.*masses fixed to links'):
        load_other_map(tmp_path / 'first.json', softer, layout)
