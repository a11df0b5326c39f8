"""A number at the end of its plausible range stops no other one."""

import numpy as np

from model_gap.campaign import Band, explicit_damping, record_spectra
from model_gap.cell import CellModel
from model_gap.effects import CubicStiffness, Scene
from model_gap.fit import descend
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor

SEED = 23
ALPHA, MOST = 1e6, 0.7
HIDDEN = {'type': 'cubic_stiffness', 'joint': 'joint_2', 'alpha': ALPHA, 'preload': 1.0}


class HardlyLoaded(CubicStiffness):
    """Gravity's whole load is not plausible."""

    most_share = MOST


def test_a_number_at_its_bound_lets_the_others_find_their_best(campaign_of, robot):
    """The share of gravity's load that would explain most lies beyond what it may be."""
    campaign = campaign_of([HIDDEN], SEED, n_fit=2, n_held=0, duration=8.0, size=0.0)
    spectra = [record_spectra(item, Band(4.0, 50.0), 90) for item in campaign.records]
    cell = CellModel(explicit_damping(robot.spec), campaign.layout.channels)
    scene = Scene(robot, tuple(sensor.name for sensor in campaign.layout), cell)
    # On the measured twist the torque is linear in α: there is one best.
    predictor = Predictor(robot, spectra, hanging=False, screening=True)
    nominal = Hypothesis(scene, (), (), np.zeros(0), np.zeros(0))
    none = np.zeros((0, len(predictor.weighting.measured)), dtype=np.float32)
    misfits = []
    for alpha in (0.5 * ALPHA, ALPHA, 3.0 * ALPHA):
        start = nominal.with_effect(HardlyLoaded('joint_2'), (alpha, MOST))
        found = descend(start, predictor, none, 12)
        assert found.hypothesis.values()[-1][1] == MOST, f'seed {SEED}: {found.hypothesis}'
        misfits.append(found.misfit)
    np.testing.assert_allclose(misfits, min(misfits), rtol=0.01, err_msg=f'seed {SEED}')
