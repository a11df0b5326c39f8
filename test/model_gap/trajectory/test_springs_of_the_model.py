"""A model whose gears have springs already: too stiff, too soft and right ones."""

import dataclasses
import json

import numpy as np
import pytest

from model_gap.trajectory import (
    corrected_model,
    EncoderFolder,
    find_encoder_gap,
    read_encoder_campaign,
    summary_lines,
)
from structural_model import load_robot
from structural_model.description import Spring
from test.support.encoder_campaign import record, write

pytestmark = pytest.mark.slow
SEED = 51
TRUTH = {0: 4.5e6, 1: 7.5e6, 2: 4.1e6}
# Of the model over the truth.
MODEL = {0: 1.4, 1: 0.7, 2: 1.0}
# A payload twists the springs of the model, too.
HIDDEN = {'stiffness': TRUTH, 'payload': (80.0, np.array([0.0, 0.0, -0.4]))}


@pytest.fixture(scope='module')
def springy():
    robot = load_robot('kuka_kr300')
    joints = tuple(
        dataclasses.replace(
            item,
            drive=dataclasses.replace(
                item.drive, spring=Spring(MODEL[place] * TRUTH[place] if place in TRUTH else 1e7)
            ),
        )
        for place, item in enumerate(robot.spec.joints)
    )
    return dataclasses.replace(robot, spec=dataclasses.replace(robot.spec, joints=joints))


@pytest.fixture(scope='module')
def campaign(springy, tmp_path_factory):
    start = springy.pose('start')
    recordings = {
        name: record(springy, start, HIDDEN, [SEED, place]) for place, name in enumerate('ab')
    }
    return write(tmp_path_factory.mktemp('campaign'), recordings)


@pytest.fixture(scope='module')
def gap(springy, campaign):
    return find_encoder_gap(springy, read_encoder_campaign(campaign, springy))


def springs(gap):
    return {law.term.axis: law for law in gap.laws if law.effect.type == 'joint_stiffness'}


def test_the_whole_stiffness_is_told_of_gears_that_are_off(gap):
    found = springs(gap)
    assert set(found) == {0, 1}, f'seed {SEED}: {[law.term.label for law in gap.laws]}'
    for axis, law in found.items():
        (number,) = law.effect.parameters
        assert abs(number.value - TRUTH[axis]) < 3.0 * number.sigma, f'seed {SEED}: {number}'
        assert number.sigma < 0.03 * TRUTH[axis], f'seed {SEED}: {number}'
        spring = corrected_model(gap).spec.joints[axis].drive.spring
        assert spring.stiffness == pytest.approx(number.value, rel=1e-12)
    text = '\n'.join(summary_lines(gap))
    assert 'softer than the model says' in text and 'stiffer than the model says' in text


def test_a_right_spring_is_confirmed(gap):
    twist = next(item for item in gap.quantities if item.name == 'twist')
    (gear,) = twist.gears
    assert gear.joint == 'joint_3' and gear.confirmed, f'seed {SEED}: {gear}'
    assert abs(gear.stiffness - TRUTH[2]) < 3.0 * gear.sigma, f'seed {SEED}: {gear}'
    assert gear.within < 0.1, f'seed {SEED}: {gear}'
    said = summary_lines(gap)
    assert any(line.startswith('confirmed: stiffness of the gear of axis 3') for line in said)
    assert not any('not told: stiffness of the gear' in line for line in said), said


def test_what_is_left_over_is_told_beside_the_noise(gap):
    """3 N m and 2 µrad, white at 250 Hz."""
    for quantity, size in zip(gap.quantities, (3.0, 2e-6), strict=True):
        noise = size * np.sqrt(10.0 / 125.0)
        for values in quantity.noise.values():
            np.testing.assert_allclose(values, noise, rtol=0.2, err_msg=f'seed {SEED}')
    lines = [line for line in summary_lines(gap) if 'held-out gap after' in line]
    assert all('noise' in line and 'of what is measured' in line for line in lines), lines


def test_the_corrected_model_has_right_springs(gap, campaign, tmp_path):
    EncoderFolder(tmp_path).write(gap)
    told = json.loads((tmp_path / 'gap.json').read_text())
    assert told['quantities']['twist']['gears_not_named'][0]['confirmed'] is True
    model = load_robot(tmp_path / 'model_updated.yaml')
    again = find_encoder_gap(model, read_encoder_campaign(campaign, model))
    assert not springs(again), f'seed {SEED}: {[law.term.label for law in again.laws]}'
    page = (tmp_path / 'report.html').read_text()
    assert 'What the data confirm' in page and 'softer than the model says' in page
