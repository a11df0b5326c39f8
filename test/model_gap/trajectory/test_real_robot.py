"""`ama gap` on a real robot, where its recordings are at hand: KUKA KR300, two trajectories."""

import json
import os
from pathlib import Path
import shlex

import pytest
from typer.testing import CliRunner

from autonomous_modal_analysis.cli import app
from structural_model import load_robot

pytestmark = pytest.mark.slow
PAGE = Path(__file__).resolve().parents[3] / 'docs' / 'tutorial' / 'real_robot.md'


@pytest.fixture(scope='module')
def out(tmp_path_factory, data_path):
    """Do what the tutorial says, in its words."""
    folder, before = tmp_path_factory.mktemp('tutorial'), Path.cwd()
    for name in ('kuka_kr300_encoders', 'other_recordings'):
        (folder / name).symlink_to(data_path('kuka_kr300_encoders'))
    lines = [line.strip() for line in PAGE.read_text().splitlines() if line.startswith('    ama ')]
    os.chdir(folder)
    try:
        said = [CliRunner().invoke(app, shlex.split(line)[1:]) for line in lines]
    finally:
        os.chdir(before)
    assert [item.exit_code for item in said] == [0, 0], [item.output for item in said]
    return folder / 'gap', said[0].output


@pytest.fixture(scope='module')
def gap(out):
    return json.loads((out[0] / 'gap.json').read_text())


def effect(gap, kind, place):
    return next(
        item for item in gap['effects'] if (item['type'], item['location']) == (kind, place)
    )


def test_held_out_errors_shrink_as_far_as_was_asked(gap):
    assert gap['heldout'] == ['trajectory_B']
    for name, most in (('torque', 1 / 3), ('twist', 1 / 5)):
        quantity = gap['quantities'][name]
        before, after = (quantity[f'rms_{key}']['trajectory_B'] for key in ('before', 'after'))
        assert all(two < most * one for one, two in zip(before, after, strict=True)), name


def test_the_counterbalance_is_named_with_its_dead_centre(gap):
    number = effect(gap, 'gravity_compensator', 'joint_2')
    assert number['rivals'] == []
    phase = number['parameters']['phase']
    # The maker's dead centre is near -95 degrees.
    assert phase['value'] == pytest.approx(-1.658, abs=0.05)


def test_stiffness_is_within_30_percent_of_what_was_published(gap):
    for joint, published in (('joint_2', 7.5189e6), ('joint_3', 4.0999e6)):
        found = effect(gap, 'joint_stiffness', joint)['parameters']['stiffness']['value']
        assert found == pytest.approx(published, rel=0.3)


def test_the_delay_of_the_link_encoders_is_named(gap):
    """Three gears of different size lag in the same time: one clock, no spring."""
    delay = effect(gap, 'sensor_delay', 'link encoders')['parameters']['delay']
    assert delay['value'] == pytest.approx(0.003, abs=3e-4)


def test_what_is_said_on_the_terminal(out):
    assert '\nnamed: ' in f'\n{out[1]}'
    assert 'no encoder behind them' in out[1]


def test_a_rival_from_data_alone_does_not_beat_the_laws(gap):
    for quantity in gap['quantities'].values():
        for rival in quantity['rival_from_data']:
            assert rival['rms_of_laws'] < rival['rms_of_data_alone']


def test_both_trajectories_agree_on_the_numbers(gap):
    """σ is honest: at most a tenth of the numbers differ by more than two."""
    far = []
    for item in gap['effects']:
        for name, one in item['parameters_of_fitted'].items():
            two = item['parameters_of_heldout'][name]
            spread = (one['sigma'] ** 2 + two['sigma'] ** 2) ** 0.5
            if spread > 0.0:
                far.append(abs(one['value'] - two['value']) > 2.0 * spread)
    assert len(far) > 20
    assert sum(far) <= 0.1 * len(far)


def test_the_corrected_model_predicts_by_itself(out, gap):
    again = json.loads((out[0].parent / 'gap_again' / 'gap.json').read_text())
    for name, most in (('torque', 1 / 3), ('twist', 1 / 5)):
        one, two = (item['quantities'][name]['rms_before'] for item in (gap, again))
        pairs = zip(one['trajectory_B'], two['trajectory_B'], strict=True)
        assert all(after < most * before for before, after in pairs), name


def test_the_corrected_model_is_a_robot(out):
    model = load_robot(out[0] / 'model_updated.yaml')
    assert [item.joint for item in model.spec.compensators] == ['joint_2']
    assert model.n_dof == 2
