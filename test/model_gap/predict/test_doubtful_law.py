"""A torque law that is not there must not gain by its doubt: noise of the motion looks like it."""

import dataclasses

import numpy as np
import pytest

from modal_core.files.share import share_path
from model_gap.campaign import Band, read_campaign, record_spectra
from model_gap.cell import CellModel, JointForce
from model_gap.fit import FIT
from model_gap.laws import BacklashLaw
from model_gap.predict import Predictor
from model_gap.search import SearchSettings
from structural_model import load_robot
from test.support.hidden_campaign import counted, make_campaign, SENSORS
from test.support.write_campaign import write_campaign

ROBOT = share_path('config', 'robots', 'irb6660_205_190')
SEED, STEP_RAD = 13, 5e-6
PLAY = (3e-5, 0.5)


@pytest.fixture(scope='module')
def predictor(tmp_path_factory):
    """A healthy arm whose motion is known by the steps of encoders."""
    robot, folder = load_robot(ROBOT), tmp_path_factory.mktemp('campaign')
    records = make_campaign(
        ROBOT, (), SEED, n_fit=2, n_held=0, duration=12.0, size=0.0, noise=0.002, velocity=False
    )
    write_campaign(folder, counted(records, STEP_RAD), robot.joint_names, SENSORS)
    campaign = read_campaign(folder, robot)
    items = [record_spectra(item, Band(3.0, 50.0)) for item in campaign.records]
    return Predictor(robot, items), CellModel(robot.spec, campaign.layout.channels)


def gains(predictor, cell, joint):
    """Log evidence that a play gains, and what of it is its doubt."""
    law = dataclasses.replace(cell, forces=(JointForce(joint, BacklashLaw, PLAY),))
    plain = predictor.weighting.misfit(predictor.rows(cell))
    with_law = predictor.weighting.misfit(predictor.rows(law))
    excused = predictor.excused_misfit(cell, law)
    return (
        FIT.effective_data * np.log(plain / with_law),
        FIT.effective_data * np.log(plain / excused),
    )


def test_a_play_that_is_not_there_gains_by_its_doubt(predictor):
    whole, doubt = gains(*predictor, 'joint_6')
    assert whole > 0.0, f'seed {SEED}: no trap, it looks worse than the truth'
    assert doubt > 1.0, f'seed {SEED}: {doubt} of {whole}'
    assert whole - doubt < SearchSettings().worth_adding, f'seed {SEED}: {whole}, {doubt}'


def test_an_arm_without_torques_is_excused_nothing(predictor):
    here, cell = predictor
    plain = here.weighting.misfit(here.rows(cell))
    assert here.excused_misfit(cell, cell) == pytest.approx(plain, rel=1e-6)
