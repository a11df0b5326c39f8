"""What is known of the joints' motion, and how well."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.files.share import share_path
from model_gap.campaign.campaign import MotionNoise
from model_gap.campaign.motion import disagreement, lag_s, white_density
from model_gap.campaign.read_campaign import read_campaign
from model_gap.campaign.resample import thinned
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel
from model_gap.predict.predict import Predictor
from test.support.hidden_campaign import counted, make_campaign, SENSORS
from test.support.write_campaign import write_campaign

SEED = 8
RATE_HZ = 250.0
STEP_RAD = 2e-5
ROBOT = share_path('config', 'robots', 'irb6660_205_190')


def motion(rng, seconds=20.0, top_hz=55.0):
    count = round(seconds * RATE_HZ)
    frequency = np.fft.rfftfreq(count, 1.0 / RATE_HZ)
    lines = np.exp(2j * np.pi * rng.random((len(frequency), 3)))
    lines[(frequency < 3.0) | (frequency > top_hz)] = 0.0
    velocity = np.fft.irfft(lines, count, axis=0)
    return velocity / velocity.std() * 0.02


def test_noise_of_an_encoder_is_read_above_the_motion(rng):
    position = np.cumsum(motion(rng), axis=0) / RATE_HZ
    counted = np.round(position / STEP_RAD) * STEP_RAD
    expected = STEP_RAD**2 / 12.0 / RATE_HZ
    np.testing.assert_allclose(white_density(counted, RATE_HZ), expected, rtol=0.25)
    assert np.all(white_density(position, RATE_HZ) < 0.01 * expected)


@pytest.mark.parametrize('late_s', [0.0, 0.0021, -0.004])
def test_lag_of_one_motion_behind_another(rng, late_s):
    early = motion(rng)
    frequency = np.fft.rfftfreq(len(early), 1.0 / RATE_HZ)
    turn = np.exp(-2j * np.pi * frequency * late_s)[:, None]
    late = np.fft.irfft(np.fft.rfft(early, axis=0) * turn, len(early), axis=0)
    assert lag_s(late, early, RATE_HZ) == pytest.approx(late_s, abs=1e-6)


def test_differenced_velocities_are_late_and_not_used(rng):
    velocity = motion(rng, top_hz=12.0)
    position = np.cumsum(velocity, axis=0) / RATE_HZ
    differenced = np.diff(position, axis=0, prepend=position[:1]) * RATE_HZ
    half_a_step = np.roll(differenced, 1, axis=0) * 0.5 + differenced * 0.5
    assert disagreement(velocity, velocity, RATE_HZ) == ''
    assert 'after the positions' in disagreement(half_a_step, velocity, RATE_HZ)
    assert 'contradict' in disagreement(-velocity, velocity, RATE_HZ)


def test_thinning_keeps_the_band_and_its_phase():
    rate, time = 2048.0, np.arange(8192) / 2048.0
    slow = np.sin(2 * np.pi * time[:, None] * np.array([5.0, 40.0, 90.0]))
    fast = np.sin(2 * np.pi * time * 700.0)[:, None]
    found = thinned(slow + fast, rate, 4)
    inside = slice(60, -60)
    assert np.abs(found[inside] - slow[::4][inside]).max() < 0.02


def test_right_model_meets_the_noise_of_a_coarse_encoder(tmp_path, robot):
    """χ of the exact model is 1 when the encoder's steps count as noise, and far above if not."""
    records = make_campaign(
        ROBOT, (), SEED, n_fit=2, n_held=0, duration=12.0, size=0.0, noise=0.002, velocity=False
    )
    write_campaign(tmp_path, counted(records, STEP_RAD), robot.joint_names, SENSORS)
    campaign = read_campaign(tmp_path, robot)
    assert campaign.excitation == 'joint positions'

    def chi(items):
        predictor = Predictor(robot, [record_spectra(item, Band(3.0, 50.0)) for item in items])
        readings = predictor.predict(CellModel(robot.spec, campaign.layout.channels))
        return predictor.weighting.misfit(predictor.weighting.rows(readings))

    known = chi(campaign.records)
    ignored = chi([replace(item, motion_noise=MotionNoise()) for item in campaign.records])
    assert 0.4 < known < 1.6, f'seed {SEED}: {known}'
    assert ignored > 5.0 * known, f'seed {SEED}: {ignored}, {known}'
