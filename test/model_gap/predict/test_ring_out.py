"""Short records end while the arm still rings; what a torque in it did to that must be known."""

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel
from model_gap.cell.joint_vector import joint_spring
from model_gap.effects import Scene
from model_gap.effects.coulomb_friction import CoulombFriction
from model_gap.effects.joint_damping import JointDamping
from model_gap.effects.tuned_mass import TunedMass
from model_gap.predict.predict import Predictor


@pytest.fixture(scope='module')
def arm(robot, campaign_of):
    """Return scene and predictor of an arm that rings for longer than its records last."""
    campaign = campaign_of(seed=7, duration=5.0, n_held=0)
    cell = CellModel(explicit_damping(robot.spec), campaign.layout.channels)
    scene = Scene(robot, tuple(sensor.name for sensor in campaign.layout), cell, ())
    records = [record_spectra(item, Band()) for item in campaign.records]
    return scene, Predictor(robot, records)


def distance(one, other):
    """Return the largest relative difference of two predictions over records and octaves."""
    found = []
    for first, second in zip(one, other, strict=True):
        for part in np.array_split(np.arange(first.shape[1]), 6):
            change = np.linalg.norm((first - second)[:, part])
            found.append(change / np.linalg.norm(first[:, part]))
    return max(found)


@pytest.mark.parametrize('joint', ['joint_1', 'joint_2'])
def test_friction_that_only_creeps_is_a_damper(arm, joint):
    scene, predictor = arm
    damper = joint_spring(scene.cell.spec, joint).damping
    torque, speed = 3e5, 1.0  # never near its level: τ tanh(v/v₀) = τ v/v₀
    friction = CoulombFriction(joint).apply(scene.cell, (torque, speed), scene)
    factor = 1.0 + torque / speed / damper
    linear = JointDamping(joint).apply(scene.cell, (factor,), scene)
    changed = distance(predictor.predict(linear), predictor.predict(scene.cell))
    error = distance(predictor.predict(linear), predictor.predict(friction))
    assert changed > 0.5, f'{changed:.3f}'
    # Straight lines between steps are (ω h)²/12 short: 3 % at the end of the band.
    assert error < 0.02, f'{error:.4f} of a response that changed by {changed:.2f}'


def test_a_held_torque_does_what_it_did(arm):
    scene, predictor = arm
    friction = CoulombFriction('joint_1').apply(scene.cell, (200.0, 1e-3), scene)
    held = predictor.hold(friction)
    assert not held.forces
    assert distance(predictor.predict(friction), predictor.predict(held)) < 1e-9
    assert distance(predictor.predict(friction), predictor.predict(scene.cell)) > 0.05
    # An arm with one coordinate more carries it as well.
    more = TunedMass('link_2', 'x').apply(held, (1e-4, 30.0, 0.3), scene)
    assert distance(predictor.predict(held), predictor.predict(more)) < 1e-4
