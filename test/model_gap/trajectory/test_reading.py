"""Encoder recordings from anywhere: one clear line for every bad file."""

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from modal_core.errors import ModalAnalysisError
from model_gap.trajectory import is_encoder_campaign, read_encoder_campaign
from structural_model import load_robot

RATE_HZ, COUNT = 250.0, 1000


@pytest.fixture(scope='module')
def robot():
    return load_robot('kuka_kr300')


def arrays(**changes):
    time = np.arange(COUNT) / RATE_HZ
    motion = 0.1 * np.sin(time)[:, np.newaxis] * np.ones(6)
    good = {
        'time_s': time,
        'motor_position_rad': motion,
        'link_position_rad': 0.999 * motion * (np.arange(6) < 3),
        'motor_torque_nm': motion,
    }
    return {key: value for key, value in (good | changes).items() if value is not None}


def with_hole():
    values = arrays()['motor_torque_nm'].copy()
    values[5, 2] = np.nan
    return values


BAD = {
    'arrays missing': arrays(motor_torque_nm=None),
    'wrong shape': arrays(motor_torque_nm=np.zeros((COUNT, 5))),
    'not finite': arrays(motor_torque_nm=with_hole()),
    'not numbers': arrays(motor_torque_nm=np.full((COUNT, 6), 'x')),
    'do not come evenly': arrays(time_s=np.arange(COUNT) ** 1.01 / RATE_HZ),
    'too short': arrays(time_s=np.arange(COUNT) / 1e5),
    'too slow': arrays(time_s=np.arange(COUNT) / 10.0),
    'do not move alike': arrays(motor_position_rad=250.0 * arrays()['motor_position_rad']),
}


@pytest.mark.parametrize('words', list(BAD))
def test_a_bad_file_is_one_line(words, robot, tmp_path):
    np.savez(tmp_path / 'a.npz', **BAD[words])
    with pytest.raises(ModalAnalysisError) as error:
        read_encoder_campaign(tmp_path, robot)
    assert words in str(error.value)
    assert 'a.npz' in str(error.value)
    assert '\n' not in str(error.value)


@pytest.mark.parametrize(
    ('missing', 'words'),
    [
        ('motor_torque_nm', 'come from the torques of the motors; motor current times'),
        ('link_position_rad', 'a joint without one has zeros'),
    ],
)
def test_what_a_missing_array_is_needed_for_is_told(missing, words, robot, tmp_path):
    np.savez(tmp_path / 'a.npz', **arrays(**{missing: None}))
    with pytest.raises(ModalAnalysisError, match=words) as error:
        read_encoder_campaign(tmp_path, robot)
    assert missing in str(error.value)


@pytest.mark.parametrize(
    'content', [b'', b'PK\x03\x04 broken', b'not a zip', np.random.default_rng(1).bytes(5000)]
)
def test_what_is_no_file_of_arrays_is_one_line(content, robot, tmp_path):
    (tmp_path / 'a.npz').write_bytes(content)
    with pytest.raises(ModalAnalysisError, match=r'a\.npz'):
        read_encoder_campaign(tmp_path, robot)


def test_objects_are_never_unpickled(robot, tmp_path):
    np.savez(tmp_path / 'a.npz', **arrays(motor_torque_nm=np.array([{}], dtype=object)))
    with pytest.raises(ModalAnalysisError, match='cannot be read'):
        read_encoder_campaign(tmp_path, robot)


def test_campaign_file_says_what_is_held_out_and_where_it_starts(robot, tmp_path):
    for number, name in enumerate('abc'):
        torque = (1.0 + number) * arrays()['motor_torque_nm']
        np.savez(tmp_path / f'{name}.npz', **arrays(motor_torque_nm=torque))
    (tmp_path / 'campaign.yaml').write_text(
        'recordings:\n- {file: a.npz, heldout: true}\n- {file: b.npz}\n- {file: c.npz}\n'
        'start_pose: [0, -80, 90, 0, 0, 0]\n'
    )
    assert is_encoder_campaign(tmp_path)
    campaign = read_encoder_campaign(tmp_path, robot)
    assert [item.name for item in campaign.heldout] == ['a']
    assert [item.name for item in campaign.fitting] == ['b', 'c']
    np.testing.assert_allclose(np.rad2deg(campaign.start), [0, -80, 90, 0, 0, 0], atol=1e-9)
    assert campaign.fitting[0].encoders == (0, 1, 2)


def test_a_copy_is_refused_and_both_are_named(robot, tmp_path):
    for name in 'ab':
        np.savez(tmp_path / f'{name}.npz', **arrays())
    with pytest.raises(ModalAnalysisError, match=r'same samples \(found a\.npz and b\.npz'):
        read_encoder_campaign(tmp_path, robot)


@pytest.mark.parametrize('pose', ['[1, 2]', '"nowhere"', '{a: 1}', '[.nan, 0, 0, 0, 0, 0]'])
def test_a_bad_start_pose_is_one_line(pose, robot, tmp_path):
    np.savez(tmp_path / 'a.npz', **arrays())
    (tmp_path / 'campaign.yaml').write_text(f'recordings: [a.npz]\nstart_pose: {pose}\n')
    with pytest.raises(ModalAnalysisError) as error:
        read_encoder_campaign(tmp_path, robot)
    assert '\n' not in str(error.value)


def test_the_vibration_of_encoders_is_refused_with_advice(robot, tmp_path):
    np.savez(tmp_path / 'a.npz', **arrays())
    with pytest.raises(ModalAnalysisError, match='find_encoder_gap'):
        ama.gap(tmp_path, robot)
