"""`ama gap` on motor and link encoders: known laws come back, healthy arms stay without a name."""

import json

import numpy as np
import pytest

from model_gap.decide import Verdict
from model_gap.trajectory import (
    corrected_model,
    EncoderFolder,
    find_encoder_gap,
    gap_share,
    read_encoder_campaign,
)
from structural_model import load_robot
from test.support.encoder_campaign import record, write

HIDDEN = {
    'coulomb': {0: 300.0, 1: 250.0, 2: 200.0},
    'viscous': {0: 1500.0, 1: 2000.0, 2: 1200.0},
    'compensator': (1, 6000.0, -1.62),
    'payload': (80.0, np.array([0.0, 0.0, -0.4])),
    'stiffness': {0: 4.5e6, 1: 7.5e6, 2: 4.1e6},
    'delay': 0.002,
}


@pytest.fixture(scope='module')
def robot():
    return load_robot('kuka_kr300')


@pytest.fixture(scope='module')
def hidden_gap(robot, tmp_path_factory):
    start = robot.pose('start')
    recordings = {
        name: record(robot, start, HIDDEN, seed) for name, seed in (('a', 11), ('b', 12))
    }
    folder = write(tmp_path_factory.mktemp('campaign'), recordings)
    return find_encoder_gap(robot, read_encoder_campaign(folder, robot))


def found(gap, kind, place):
    (law,) = [
        item for item in gap.laws if (item.effect.type, item.effect.location) == (kind, place)
    ]
    return {item.name: item for item in law.effect.parameters}


def within(number, truth, sigmas=3.0, floor=0.0):
    assert abs(number.value - truth) < sigmas * number.sigma + floor, (number, truth)


@pytest.mark.slow
def test_what_was_hidden_is_found_with_honest_numbers(hidden_gap):
    assert hidden_gap.verdict is Verdict.NAMED
    within(found(hidden_gap, 'payload', 'tool0')['mass'], 80.0)
    compensator = found(hidden_gap, 'gravity_compensator', 'joint_2')
    within(compensator['strength'], 6000.0)
    within(compensator['phase'], -1.62)
    within(found(hidden_gap, 'sensor_delay', 'link encoders')['delay'], 0.002)
    for joint, stiffness in HIDDEN['stiffness'].items():
        number = found(hidden_gap, 'joint_stiffness', f'joint_{joint + 1}')['stiffness']
        # What passes through the gear is computed: its own small errors are the gear's.
        within(number, stiffness, floor=0.02 * stiffness)
        assert number.sigma < 0.2 * stiffness
    for joint, damping in HIDDEN['viscous'].items():
        number = found(hidden_gap, 'viscous_friction', f'joint_{joint + 1}')['damping']
        within(number, damping, floor=0.005 * damping)
    for joint, torque in HIDDEN['coulomb'].items():
        number = found(hidden_gap, 'coulomb_friction', f'joint_{joint + 1}')['torque']
        within(number, torque, floor=0.05 * torque)


@pytest.mark.slow
def test_the_gap_of_the_recording_held_out_shrinks(hidden_gap):
    for quantity in hidden_gap.quantities:
        assert gap_share(quantity, ['b']) < 0.1


@pytest.mark.slow
def test_the_corrected_model_predicts_a_third_recording(robot, hidden_gap, tmp_path):
    third = write(tmp_path / 'third', {'c': record(robot, robot.pose('start'), HIDDEN, 13)})
    EncoderFolder(tmp_path).write(hidden_gap)
    model = load_robot(tmp_path / 'model_updated.yaml')
    assert model.spec == corrected_model(hidden_gap).spec
    plain, better = (
        find_encoder_gap(arm, read_encoder_campaign(third, arm)) for arm in (robot, model)
    )
    for one, two in zip(plain.quantities, better.quantities, strict=True):
        for name in one.before:
            assert (two.before[name][:3] < 0.2 * one.before[name][:3]).all()
    assert json.loads((tmp_path / 'gap.json').read_text())['verdict'] == 'named'


@pytest.mark.slow
@pytest.mark.parametrize('seed', [21, 22])
def test_a_healthy_arm_gets_no_name(robot, tmp_path, seed):
    start = robot.pose('start')
    stiff = {'stiffness': {0: 1e12, 1: 1e12, 2: 1e12}}
    recordings = {
        name: record(robot, start, stiff, [seed, place]) for place, name in enumerate('ab')
    }
    folder = write(tmp_path, recordings)
    gap = find_encoder_gap(robot, read_encoder_campaign(folder, robot))
    assert [law.term.label for law in gap.laws] == []
    assert gap.verdict is Verdict.NONE


@pytest.mark.slow
def test_a_law_outside_the_catalogue_is_unexplained_and_drawn(robot, tmp_path):
    """A stop of rubber in axis 1: nothing up to an angle, then ever more."""
    start = robot.pose('start')

    def with_stop(seed):
        arrays = record(robot, start, {'stiffness': {0: 1e12}}, seed)
        beyond = np.maximum(np.abs(arrays['motor_position_rad'][:, 0]) - 0.08, 0.0)
        sign = np.sign(arrays['motor_position_rad'][:, 0])
        ratio = robot.spec.joints[0].drive.gear_ratio
        arrays['motor_torque_nm'][:, 0] += 4e4 * sign * beyond**1.5 / ratio
        return arrays

    folder = write(tmp_path, {name: with_stop(seed) for name, seed in (('a', 31), ('b', 32))})
    gap = find_encoder_gap(robot, read_encoder_campaign(folder, robot))
    assert gap.verdict is Verdict.UNEXPLAINED
    (only,) = gap.unexplained
    assert only[:2] == ('torque', 'axis_1')
    assert only[2].input == ('angle', 0)
    EncoderFolder(tmp_path / 'out').write(gap)
    page = (tmp_path / 'out' / 'report.html').read_text()
    assert 'left over of the torque of axis 1' in page
    assert 'src=' not in page and "default-src 'none'" in page
    assert 'data-chart="curves"' in page and 'kN m' in page
