"""Gear orders sought in what is left over."""

from dataclasses import replace

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel, Ripple
from model_gap.effects import Scene
from model_gap.effects.transmission_error import TransmissionError
from model_gap.hypothesis.hypothesis import Hypothesis
from model_gap.predict.predict import Predictor
from model_gap.search.orders import orders_left

SEED = 31
AMPLITUDE = 3e-4


def left_of(campaign, robot):
    """Return the nominal hypothesis and a predictor of the records."""
    spectra = [record_spectra(item, Band(4.0, 50.0), 120) for item in campaign.records]
    cell = CellModel(explicit_damping(robot.spec), campaign.layout.channels)
    names = tuple(sensor.name for sensor in campaign.layout)
    nominal = Hypothesis(Scene(robot, names, cell), (), (), np.zeros(0), np.zeros(0))
    return nominal, Predictor(robot, spectra, hanging=False)


@pytest.mark.parametrize('turns', [1.0, 5.0])
def test_hidden_order_is_seen_in_its_joint(turns, campaign_of, robot):
    """A sine of 200 or 1000 radians per radian: order, amplitude and phase."""
    hidden = {
        'type': 'transmission_error',
        'joint': 'joint_2',
        'amplitude': AMPLITUDE,
        'order': turns,
    }
    campaign = campaign_of([hidden], SEED, n_fit=4, n_held=0, duration=10.0, size=0.0)
    nominal, predictor = left_of(campaign, robot)
    ratio = next(item.drive.gear_ratio for item in robot.spec.joints if item.name == 'joint_2')
    seen = orders_left(nominal, predictor, ('joint_2',))
    right = [item for item in seen if abs(item.order_per_rad / (turns * ratio) - 1.0) < 0.002]
    assert right, f'seed {SEED}: {seen}'
    (ripple,) = right
    assert ripple.sine_rad == pytest.approx(AMPLITUDE, rel=0.1), f'seed {SEED}: {ripple}'
    assert abs(ripple.cosine_rad) < 0.15 * AMPLITUDE, f'seed {SEED}: {ripple}'


def test_healthy_arm_shows_no_order(campaign_of, robot):
    campaign = campaign_of([], SEED, n_fit=4, n_held=0, duration=10.0, size=0.0)
    nominal, predictor = left_of(campaign, robot)
    assert orders_left(nominal, predictor, nominal.scene.flexible_joints) == ()


def test_a_parked_joint_shows_no_order(campaign_of, robot):
    campaign = campaign_of([], SEED, n_fit=2, n_held=0, duration=6.0, size=0.0)
    parked = robot.joint_names.index('joint_6')
    for item in campaign.records:
        item.pose[parked], item.motor_shift[:, parked] = 0.5, 0.0
    nominal, predictor = left_of(campaign, robot)
    assert orders_left(nominal, predictor, ('joint_6',)) == ()


def test_every_order_seen_is_a_candidate_of_its_own(campaign_of, robot):
    """Other joints are tried once per turn of the motor."""
    nominal, _ = left_of(campaign_of([], SEED, n_fit=1, n_held=0, duration=6.0), robot)
    others = [name for name in nominal.scene.flexible_joints if name != 'joint_2']
    seen = (Ripple('joint_2', 200.0, 1e-4, 0.0), Ripple('joint_2', 713.0, 0.0, 2e-4))
    scene = replace(nominal.scene, ripples=seen)
    found = TransmissionError.instances(scene)
    assert [item.location for item in found] == ['joint_2', 'joint_2', *others]
    for effect, ripple in zip(found, seen, strict=False):
        assert effect.starts(scene) == [(ripple.sine_rad, ripple.cosine_rad, ripple.order_per_rad)]
        assert effect.parameters(scene)[2].neutral == ripple.order_per_rad
    assert all(len(effect.starts(scene)) == 4 for effect in found[2:])
