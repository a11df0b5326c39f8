"""A mode that moves with the pose is one mode with a range."""

import numpy as np
import pytest

from autonomous_modal_analysis.identified.mode_tracks import mode_tracks
from autonomous_modal_analysis.identified.results import IdentifiedWindow
from modal_core.mode import Mode, ModeSet
from modal_core.window import Pose

SEED = 5


def windows(frequency_of, n_poses=4, per_pose=6, std_hz=0.05, known=True):
    """Return windows in several poses; mode k is at ``frequency_of[k](pose)`` within its σ."""
    rng = np.random.default_rng(SEED)
    made = []
    for number in range(n_poses * per_pose):
        place = number // per_pose
        pose = Pose(('a', 'b'), np.array([0.4 * place, 0.1]), np.zeros(2)) if known else None
        modes = tuple(
            Mode(f(place) + std_hz * rng.standard_normal(), 0.02, np.ones(2), std_hz, id=k + 1)
            for k, f in enumerate(frequency_of)
        )
        found = ModeSet(modes, ('c', 'd'))
        made.append(IdentifiedWindow(number, number, number + 1, found, pose=pose))
    return made


def test_only_the_mode_that_moves_is_said_to():
    still, moving = mode_tracks(windows([lambda _: 10.0, lambda place: 15.0 + place]))
    assert not still.moves_with_pose, f'seed {SEED}'
    assert moving.moves_with_pose
    assert (moving.n_windows, moving.n_poses) == (24, 4)
    assert moving.lowest_hz == pytest.approx(15.0, abs=0.1)
    assert moving.highest_hz == pytest.approx(18.0, abs=0.1)
    assert moving.words().startswith('mode 2 moves with the pose')
    assert moving.words().endswith('Hz in 4 poses')


def test_without_poses_nothing_is_said_to_move_with_them():
    (track,) = mode_tracks(windows([lambda place: 15.0 + place], known=False))
    assert not track.moves_with_pose and track.n_poses == 0
    assert track.highest_hz - track.lowest_hz > 2.5


def test_one_pose_visited_again_is_one_pose():
    there_and_back = windows([lambda _: 10.0], n_poses=2) + windows([lambda _: 10.0], n_poses=2)
    (track,) = mode_tracks(there_and_back)
    assert (track.n_windows, track.n_poses) == (24, 2)


def test_scatter_alone_hardly_ever_counts_as_motion():
    many = [lambda _: 10.0] * 200
    told = sum(
        track.moves_with_pose for track in mode_tracks(windows(many, n_poses=8, per_pose=1))
    )
    assert told <= 4, f'{told} of 200, seed {SEED}'
