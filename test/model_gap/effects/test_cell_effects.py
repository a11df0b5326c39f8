"""Effects of the cell against an arm that shares no code: with the truth in it, noise is left."""

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.read_campaign import read_campaign
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel
from model_gap.effects import Scene
from model_gap.effects.base_compliance import BaseCompliance
from model_gap.effects.cable import Cable
from model_gap.effects.cubic_damping import CubicDamping
from model_gap.effects.encoder_offset import EncoderOffset
from model_gap.effects.end_stop import EndStop
from model_gap.effects.foundation_mode import FoundationMode
from model_gap.effects.gravity_compensator import GravityCompensator
from model_gap.effects.hysteresis import Hysteresis
from model_gap.effects.load_friction import LoadFriction
from model_gap.effects.places import centre_at_zero
from model_gap.effects.sensor_position import SensorPosition
from model_gap.effects.sensor_unit import SensorUnit
from model_gap.effects.stiffness_drift import StiffnessDrift
from model_gap.effects.stribeck_friction import StribeckFriction
from model_gap.predict.predict import Predictor
from structural_model import load_robot
from test.model_gap.conftest import ROBOT
from test.support.cell_campaign import cell_campaign
from test.support.hidden_campaign import SENSORS
from test.support.write_campaign import write_campaign

SEED = 31
TURN = 0.06
UNIT = {'kind': 'sensor', 'turned': {'elbow': np.eye(3) / 9.80665}}
STRENGTH, PHASE = 4e4, 0.7
BLOCK = {'kind': 'foundation_mode', 'mass': 3000.0, 'gyration': 1.0, 'f': 13.6, 'zeta': 0.03}
COMPLIANCE, LOSS_S, LIGHT = 6e-8, 3e-3, 5.0
# Light enough to be nothing but springs below those of the base: nothing works out the series.
SOFT = {
    **BLOCK, 'along': ['rx', 'ry'], 'mass': LIGHT,
    'f': (COMPLIANCE * LIGHT) ** -0.5 / (2 * np.pi),
    'zeta': 0.5 * LOSS_S * (COMPLIANCE * LIGHT) ** -0.5,
}  # fmt: skip
ARM = load_robot(ROBOT)
STIFF = ARM.spec.joints[0].drive.spring.stiffness
HUNG, ANCHOR = (0.4, 0.0, 0.1), (0.5, 1.5, 3.0)


def from_afar(anchor):
    """Return how far a cable's direction is turned from z, and 1 / distance [1/m]."""
    x, y, z = np.array(anchor) - centre_at_zero(Scene(ARM, (), CellModel(ARM.spec, ())), 'link_4')
    return np.arctan(x / z), np.arctan(y / z), np.sign(z) / np.linalg.norm([x, y, z])


CASES = {
    'encoder_offset': (
        {'kind': 'encoder_offset', 'joint': 'joint_3', 'offset': TURN},
        EncoderOffset('joint_3'),
        (TURN,),
    ),
    'sensor_position': (
        {'kind': 'sensor_position', 'sensor': 'elbow', 'shift': (0.05, -0.08, 0.03)},
        SensorPosition('sensor:elbow'),
        (0.05, -0.08, 0.03),
    ),
    'sliding': (
        {**BLOCK, 'along': ['tx']},
        FoundationMode(None, 'along x'),
        (1.0 / 3000.0, 13.6, 0.03),
    ),
    'rocking': (
        {**BLOCK, 'along': ['rx', 'ry']},
        FoundationMode(None, 'about x and y'),
        (1.0 / 3000.0, 13.6, 0.03),
    ),
    'base_compliance': (SOFT, BaseCompliance(), (COMPLIANCE, LOSS_S)),
    'cable': (
        {'kind': 'cable', 'link': 'link_4', 'at': HUNG, 'anchor': ANCHOR, 'k': 6e4},
        Cable('link_4', details=True),
        (6e4, *from_afar(ANCHOR), *HUNG, 0.0),
    ),
    'sensor_unit': (UNIT, SensorUnit('sensor:elbow'), ()),
    'gravity_compensator': (
        {'kind': 'gravity_compensator', 'joint': 'joint_2', 'strength': STRENGTH, 'phase': PHASE},
        GravityCompensator('joint_2'),
        (STRENGTH * np.cos(PHASE), STRENGTH * np.sin(PHASE)),
    ),
}


LAWS = {
    'hysteresis': (
        {'type': 'hysteresis', 'joint': 'joint_1', 'share': 0.4, 'limit': 5e-5},
        Hysteresis('joint_1'),
        (0.4, 5e-5),
    ),
    'end_stop': (
        {'type': 'end_stop', 'joint': 'joint_1', 'gap': 1e-4, 'k': 4e6},
        EndStop('joint_1'),
        (1e-4, 4e6 / STIFF),
    ),
    'stribeck_friction': (
        {
            'type': 'stribeck_friction', 'joint': 'joint_1', 'torque': 80.0, 'static': 160.0,
            'speed': 5e-3,
        },
        StribeckFriction('joint_1'),
        (80.0, 1e-3, 1.0, 5e-3),
    ),
    'load_friction': (
        {'type': 'load_friction', 'joint': 'joint_2', 'torque': 30.0, 'share': 0.04, 'v0': 1e-3},
        LoadFriction('joint_2'),
        (30.0, 1e-3, 0.04),
    ),
    'stiffness_drift': (
        {'type': 'drifting_stiffness', 'joint': 'joint_1', 'rate': 0.2},
        StiffnessDrift('joint_1'),
        (-0.2 / 6.0,),
    ),
    'cubic_damping': (
        {'type': 'cubic_damping', 'joint': 'joint_1', 'c': 2e7},
        CubicDamping('joint_1'),
        (2e7,),
    ),
}  # fmt: skip


def left_over(hidden, robot, layout, folder, *hypotheses):
    """Return the misfit of each hypothesis: effect and values; the last is of the bare arm."""
    law = [hidden] if 'type' in hidden else []
    cell = [] if law else [hidden]
    records = cell_campaign(
        ROBOT, SEED, *cell, effects=law, mount_deg=0.0, size=0.0, n_fit=2, n_held=0, duration=6.0,
        levels=(1.0,), noise=0.01,
    )  # fmt: skip
    write_campaign(folder, records, robot.joint_names, SENSORS)
    spectra = [record_spectra(it, Band(), 100) for it in read_campaign(folder, robot).records]
    cell = CellModel(explicit_damping(robot.spec), layout.channels)
    scene = Scene(robot, tuple(sensor.name for sensor in layout), cell)
    predictor = Predictor(robot, spectra, hanging=False)
    cells = [effect.apply(cell, values, scene) for effect, values in hypotheses]
    squares = [predictor.squares(one) for one in (*cells, cell)]
    return [float(np.mean(np.concatenate([it.ravel() for it in one]))) for one in squares]


@pytest.mark.parametrize('kind', CASES)
def test_the_truth_leaves_noise_and_nothing_else_does(kind, robot, layout, tmp_path):
    hidden, effect, values = CASES[kind]
    left = left_over(hidden, robot, layout, tmp_path, (effect, values))
    assert left[0] < 2.0, f'seed {SEED}: {left}'
    assert left[1] > 8.0 * left[0], f'seed {SEED}: {left}'


def test_how_lossy_a_foundation_is_shows_beside_the_springs_of_the_base(robot, layout, tmp_path):
    effect = BaseCompliance()
    near, far = (effect, (COMPLIANCE, LOSS_S)), (effect, (COMPLIANCE, 0.1 * LOSS_S))
    left = left_over(SOFT, robot, layout, tmp_path, near, far)
    assert left[1] > 1.5 * left[0], f'seed {SEED}: {left}'


@pytest.mark.parametrize('kind', LAWS)
def test_a_law_of_a_joint_is_that_of_an_arm_stepped_otherwise(kind, robot, layout, tmp_path):
    """Explicit steps there, implicit ones here: both leave a few percent of what the law does."""
    hidden, effect, values = LAWS[kind]
    left = left_over(hidden, robot, layout, tmp_path, (effect, values))
    assert left[0] - 1.0 < 0.03 * (left[1] - 1.0), f'seed {SEED}: {left}'
