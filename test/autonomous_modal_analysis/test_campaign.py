"""`ama campaign`: poses, plans, recordings, and going on after an interruption."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from abb_emulator.run_plan import ArmOptions
from autonomous_modal_analysis.campaigns.campaign_plan import (
    CampaignWish,
    DEFAULTS,
    planned_recordings,
    STATE_DEFAULTS,
)
from autonomous_modal_analysis.campaigns.campaign_poses import choose_poses
from autonomous_modal_analysis.campaigns.campaign_recording import (
    CampaignFolder,
    is_whole,
    record_campaign,
)
from autonomous_modal_analysis.campaigns.emulated_player import EmulatedPlayer
from excitation_planner.request import PlanRequest
from modal_core.errors import PlanError, SettingsError
from model_gap.campaign.read_campaign import read_campaign
from structural_model import load_layout, load_robot

ROBOT = 'irb6660_205_190'
SEED = 3
SHORT = PlanRequest.from_mapping({**DEFAULTS, 'duration_s': 3.0, 'seed': SEED})


@pytest.fixture(scope='module')
def robot():
    return load_robot(ROBOT)


@pytest.fixture(scope='module')
def sensors():
    return load_layout(ROBOT, 'sensors_light')


@pytest.mark.parametrize('name', [ROBOT, 'generic_arm_6'])
def test_poses_are_far_apart_and_inside_every_limit(name):
    model, layout = load_robot(name), load_layout(name)
    poses = choose_poses(model, layout, 6, SHORT)
    again = choose_poses(model, layout, 6, SHORT)
    for pose, same in zip(poses, again, strict=True):
        np.testing.assert_array_equal(pose, same)
        model.check_pose(pose)
        assert model.geometry.clearance(pose).distance_m > 0.02
        assert model.geometry.skeleton(pose)[2:, 2].min() > 0.0
    angles = np.array(poses)
    apart = np.linalg.norm(angles[:, None] - angles[None], axis=2)
    assert apart[~np.eye(6, dtype=bool)].min() > 1.0, f'seed {SEED}'


def with_limits(model, **changed):
    """The same arm, some limits of one axis lower."""
    limits = model.limits
    values = {
        name: np.where(np.arange(model.n_joints) == axis, value, getattr(limits, name))
        for name, (axis, value) in changed.items()
    }
    return replace(model, limits=replace(limits, **values))


def test_a_slow_axis_shakes_less_and_its_plan_is_made(robot, sensors):
    slow = with_limits(robot, acceleration=(4, 2.0))
    wish = CampaignWish(n_poses=1, levels=(1.0,), request=SHORT)
    (item,) = planned_recordings(slow, sensors, wish)
    assert item.request.joint_weights[4] == pytest.approx(2.0 / 5.0 / 1.2, rel=1e-3)
    assert item.plan(slow, sensors).peak_acceleration[4] <= 2.0
    for shared in ({'joints': ('axis_1', 'axis_5')}, {'require_full_rank': True}):
        own = replace(SHORT, **shared)
        (item,) = planned_recordings(slow, sensors, replace(wish, request=own))
        assert item.request.joint_weights == (), f'{shared}: somebody else decides'


def test_poses_are_ones_that_drives_can_hold(robot, sensors):
    still = np.zeros(robot.n_joints)
    hold = [
        abs(robot.drive_torque(pose, still, still))[1]
        for pose in choose_poses(robot, sensors, 6, SHORT)
    ]
    weak = with_limits(robot, effort=(1, float(np.median(hold)) + 2500.0))
    for pose in choose_poses(weak, sensors, 6, SHORT):
        assert abs(weak.drive_torque(pose, still, still))[1] < weak.limits.effort[1], (
            f'seed {SEED}'
        )
    with pytest.raises(PlanError, match='too few poses'):
        choose_poses(with_limits(robot, effort=(1, 1.0)), sensors, 1, SHORT)


def test_a_band_without_modes_is_told(robot, sensors):
    with pytest.raises(PlanError, match='raise band_high_hz'):
        choose_poses(robot, sensors, 1, replace(SHORT, band_low_hz=0.6, band_high_hz=1.2))


def test_a_box_no_pose_fits_into_is_one_clear_line(robot, sensors):
    tiny = replace(SHORT, box_m=(0.0, 0.0, 0.0, 0.1, 0.1, 0.1))
    with pytest.raises(PlanError, match='too few poses') as caught:
        choose_poses(robot, sensors, 3, tiny)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize('levels', [(), (1.0, 1.0), (2.0,), (0.0,)])
def test_bad_levels_are_refused(levels):
    with pytest.raises(SettingsError, match='levels'):
        CampaignWish(levels=levels)


def test_levels_of_a_pose_play_the_same_motion_scaled(robot, sensors):
    wish = CampaignWish(n_poses=1, levels=(1.0, 0.5), request=SHORT)
    loud, quiet = (item.plan(robot, sensors) for item in planned_recordings(robot, sensors, wish))
    start = loud.position[0]
    np.testing.assert_allclose(quiet.position - start, 0.5 * (loud.position - start), atol=1e-10)


@pytest.mark.slow
def test_a_campaign_goes_on_where_it_stopped(robot, sensors, tmp_path):
    """One file is there, one is cut off, one is missing: two are recorded, all are the same."""
    wish = CampaignWish(n_poses=3, levels=(1.0,), request=SHORT)
    planned = planned_recordings(robot, sensors, wish)
    player = EmulatedPlayer(
        ArmOptions.from_mapping({'robot': ROBOT, 'sensors_file': 'sensors_light'})
    )
    folder = CampaignFolder(tmp_path, robot, sensors, player.options, ('a remark',))
    played = []

    def play(plan, path, progress):
        played.append(path.name)
        player.play(plan, path, progress)

    record_campaign(folder, planned, play)
    files = [tmp_path / item.file for item in planned]
    whole = [file.read_bytes() for file in files]
    plans = [item.plan(robot, sensors) for item in planned]
    assert all(is_whole(file, plan) for file, plan in zip(files, plans, strict=True))
    files[1].write_bytes(whole[1][: len(whole[1]) // 2])
    files[2].unlink()
    assert not is_whole(files[1], plans[1])
    assert not is_whole(files[0], plans[1]), 'another plan'
    played.clear()
    record_campaign(folder, planned, play)
    assert played == [item.file for item in planned[1:]]
    assert [file.read_bytes() for file in files] == whole
    assert not list(tmp_path.glob('.*.part'))

    campaign = read_campaign(tmp_path, robot)
    assert campaign.remarks == ('a remark',)
    assert len(campaign.layout.channels) == 12
    for record, item in zip(campaign.records, planned, strict=True):
        np.testing.assert_allclose(record.pose, item.pose, atol=1e-3)
    other = replace(folder, conditions='another arm')
    with pytest.raises(SettingsError, match='other conditions'):
        record_campaign(other, planned, play)


def test_a_campaign_that_is_stopped_again_lists_what_it_had(robot, sensors, tmp_path):
    wish = CampaignWish(n_poses=1, levels=(1.0, 0.5, 0.25), request=SHORT)
    planned = planned_recordings(robot, sensors, wish)
    folder = CampaignFolder(tmp_path, robot, sensors)
    record_campaign(folder, planned, lambda plan, path, progress: path.touch())
    before = yaml.safe_load((tmp_path / 'campaign.yaml').read_text())
    assert len(before['recordings']) == 3

    def stopped(plan, path, progress):
        if path.name == planned[1].file:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        record_campaign(folder, planned, stopped)
    assert yaml.safe_load((tmp_path / 'campaign.yaml').read_text()) == before


def test_what_is_hidden_in_the_arm_stays_hidden(robot, sensors, tmp_path):
    wish = CampaignWish(n_poses=1, levels=(1.0,), request=SHORT)
    hidden = [{'type': 'backlash', 'joint': 'joint_2', 'half_gap': 1e-4}]
    player = EmulatedPlayer(
        ArmOptions.from_mapping(
            {'robot': ROBOT, 'sensors_file': 'sensors_light', 'effects': hidden}
        )
    )
    folder = CampaignFolder(tmp_path, robot, sensors, player.options)
    path = record_campaign(folder, planned_recordings(robot, sensors, wish), player.play)
    assert 'backlash' not in path.read_text()
    assert set(yaml.safe_load(path.read_text())) == {
        'robot', 'conditions', 'notes', 'sensors', 'recordings',
    }  # fmt: skip


def test_states_of_a_pose_leave_joints_standing_or_let_them_slide(robot, sensors):
    """The third conclusion of the paper needs both: presliding in one, sliding in the other."""
    request = PlanRequest.from_mapping({**STATE_DEFAULTS, 'duration_s': 12.0, 'seed': SEED})
    wish = CampaignWish(poses=[robot.pose('P3')], states=('standing', 'running'), request=request)
    planned = planned_recordings(robot, sensors, wish)
    assert [item.file for item in planned] == ['pose_01_standing.mcap', 'pose_01_running.mcap']
    standing, running = (item.plan(robot, sensors) for item in planned)
    moved = np.abs(robot.to_controller(standing.position - standing.position[0]))
    assert moved.max() < 0.07 * request.presliding_rad
    assert max(standing.prediction.sliding_share) == 0.0
    assert running.signal == 'sliding_noise'
    assert min(running.prediction.sliding_share) > 0.8
    with pytest.raises(SettingsError, match='unknown state'):
        CampaignWish(states=('walking',))
