"""The next pose is the one that takes most variance per second."""

import numpy as np

from benchmarks.workspace_map.hidden_arms import known_arm
from structural_model import load_layout, load_robot
from structural_model.equations import random_poses
from workspace_map import Arm, candidates, choose_series, ToolPoint, WorkspaceMap
from workspace_map.regression import posterior, Rows

SEED = 5


def drawn_choice():
    known = WorkspaceMap(known_arm(), 60.0)
    poses = random_poses(known.arm.model.limits, 12, np.random.default_rng(SEED))
    return known, candidates(known, poses[:8], poses[8:], 60.0)


def left(known, choice, numbers):
    """Return what is left of the variance of interest when some candidates are measured."""
    taken = np.isin(choice.rows.pose, numbers)
    rows = Rows(
        tuple(part[taken] for part in choice.rows.parts),
        choice.rows.q,
        choice.rows.pose[taken],
        choice.rows.kind[taken],
    )
    scales = known.found_scales[0]
    noise = np.sqrt(choice.variance[taken] - scales.white[rows.kind] ** 2)
    found = posterior(rows, np.zeros(len(rows)), noise, scales)
    return np.trace(found.covariance(choice.of_interest, choice.of_interest))


def test_the_chosen_poses_leave_least_variance():
    """By brute force over all candidates, one after the other; seed 5."""
    known, choice = drawn_choice()
    first, second = choose_series(known, choice, 2, lambda here, q: np.ones(len(q)))
    assert first == np.argmin([left(known, choice, [n]) for n in range(8)])
    others = [n for n in range(8) if n != first]
    assert second == others[int(np.argmin([left(known, choice, [first, n]) for n in others]))]


def test_a_pose_that_takes_long_to_reach_is_taken_later():
    known, choice = drawn_choice()
    best, *_ = choose_series(known, choice, 3, lambda here, q: np.ones(len(q)))
    far = np.ones(8)
    far[best] = 1e6
    others = choose_series(known, choice, 3, lambda here, q: far)
    assert best not in others
    assert len(set(others)) == 3


def test_an_arm_without_base_springs_and_with_a_tool_frame_has_next_poses():
    """No link may be corrected that is only fixed to a moving one, as a tool's frame is."""
    model = load_robot('generic_arm_6')
    assert 'tool0' in model.link_names and 'tool0' not in model.body_links
    layout = load_layout('generic_arm_6')
    known = WorkspaceMap(Arm(model, layout.channels, ToolPoint('tool0')), 60.0)
    assert len(known.arm.heavier) == len(model.body_links)
    poses = random_poses(model.limits, 5, np.random.default_rng(SEED))
    choice = candidates(known, poses[:3], poses[3:], 60.0)
    assert len(choose_series(known, choice, 2, lambda here, q: np.ones(len(q)))) == 2
