"""The prediction against an arm that shares no code with it."""

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel
from model_gap.effects import Scene
from model_gap.effects.coulomb_friction import CoulombFriction
from model_gap.effects.cubic_stiffness import CubicStiffness
from model_gap.effects.sensor_mount_resonance import SensorMountResonance
from model_gap.effects.servo_compliance import ServoCompliance
from model_gap.predict.predict import Predictor

EXACT = {'size': 0.0, 'noise': 1e-4, 'n_fit': 2, 'n_held': 0, 'duration': 28.0}
CASES = [
    ('nothing', None, None, (), 0.01),  # leakage of the record's end
    pytest.param(
        'friction',
        {'type': 'coulomb_friction', 'joint': 'joint_2', 'torque': 150.0, 'v0': 1e-3},
        CoulombFriction('joint_2'),
        (150.0, 1e-3),
        0.04,
        marks=pytest.mark.slow,  # its arm takes 16,000 steps a second
    ),
    (
        'cubic',
        {'type': 'cubic_stiffness', 'joint': 'joint_2', 'alpha': 1e6},
        CubicStiffness('joint_2'),
        (1e6, 0.0),
        0.04,
    ),
    (
        'preloaded cubic',
        {'type': 'cubic_stiffness', 'joint': 'joint_2', 'alpha': 1e6, 'preload': 1.0},
        CubicStiffness('joint_2'),
        (1e6, 1.0),
        0.04,
    ),
    (
        'servo',
        {'type': 'servo_compliance', 'f': 30.0, 'zeta': 0.5},
        ServoCompliance(),
        (30.0, 0.5),
        0.02,
    ),
    (
        'servo that lags',
        {'type': 'servo_compliance', 'f': 30.0, 'zeta': 0.5, 'feedforward': 0.0},
        ServoCompliance(details=True),
        (30.0, 0.5, 0.0, 1.0),
        0.02,
    ),
    (
        'accelerometer of its own resonance',
        {'type': 'sensor_mount_resonance', 'sensor': 'elbow', 'f': 80.0, 'zeta': 0.08},
        SensorMountResonance('sensor:elbow', details=True),
        (80.0, 0.08, 0.0),
        0.01,
    ),
]


@pytest.mark.parametrize(('name', 'hidden', 'effect', 'values', 'allowed'), CASES)
@pytest.mark.slow
def test_spectra_agree_with_independent_arm(
    name, hidden, effect, values, allowed, campaign_of, robot
):
    seed = 11
    campaign = campaign_of([hidden] if hidden else [], seed, **EXACT)
    spectra = [record_spectra(item, Band(4.0, 50.0)) for item in campaign.records]
    cell = CellModel(explicit_damping(robot.spec), campaign.layout.channels)
    names = tuple(sensor.name for sensor in campaign.layout)
    if effect is not None:
        cell = effect.apply(cell, values, Scene(robot, names, cell))
    predicted = Predictor(robot, spectra, hanging=False).predict(cell)  # as that arm
    for item, reading in zip(spectra, predicted, strict=True):
        error = np.linalg.norm(item.measured - reading) / np.linalg.norm(item.measured)
        assert error < allowed, f'{name}, seed {seed}, {item.record.name}: {error:.4f}'
