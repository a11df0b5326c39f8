"""Late commands and lagging servos in records that are cut off while everything moves."""

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel
from model_gap.effects import Scene
from model_gap.effects.clock_drift import ClockDrift
from model_gap.effects.command_delay import CommandDelay
from model_gap.effects.servo_compliance import ServoCompliance
from model_gap.predict.driven import driven_motion
from model_gap.predict.predict import Predictor
from model_gap.search.search_data import shortened

SEED = 23
CASES = [
    ({'type': 'command_delay', 'delay': 0.015}, CommandDelay(), (0.015,)),
    ({'type': 'clock_drift', 'rate': 1e-4}, ClockDrift(), (1e-4,)),
    ({'type': 'clock_drift', 'rate': -1e-4}, ClockDrift(), (-1e-4,)),
    (
        {'type': 'servo_compliance', 'f': 25.0, 'zeta': 0.4, 'feedforward': 0.0},
        ServoCompliance(details=True),
        (25.0, 0.4, 0.0, 1.0),
    ),
]


@pytest.mark.parametrize(('hidden', 'effect', 'values'), CASES)
def test_cut_off_records_agree_with_independent_arm(hidden, effect, values, campaign_of, robot):
    options = {'size': 0.0, 'noise': 1e-4, 'n_fit': 1, 'n_held': 0, 'duration': 14.0}
    campaign = campaign_of([hidden], SEED, **options)
    records = [shortened(item, 8.0) for item in campaign.records]
    spectra = [record_spectra(item, Band(4.0, 50.0)) for item in records]
    cell = CellModel(explicit_damping(robot.spec), campaign.layout.channels)
    names = tuple(sensor.name for sensor in campaign.layout)
    cell = effect.apply(cell, values, Scene(robot, names, cell))
    for item, reading in zip(
        spectra, Predictor(robot, spectra, hanging=False).predict(cell), strict=True
    ):
        error = np.linalg.norm(item.measured - reading) / np.linalg.norm(item.measured)
        assert error < 0.01, f'seed {SEED}, {item.record.name}: {error:.4f}'


def test_nothing_comes_in_again_at_the_start(campaign_of, robot):
    """Half a second late: the first half second is at rest, the last one is gone."""
    campaign = campaign_of([], SEED, size=0.0, n_fit=1, n_held=0, duration=6.0)
    item = record_spectra(shortened(campaign.records[0], 4.0), Band(4.0, 50.0))
    plain = CellModel(explicit_damping(robot.spec), campaign.layout.channels)
    names = tuple(sensor.name for sensor in campaign.layout)
    late = CommandDelay().apply(plain, (0.5,), Scene(robot, names, plain))
    motion = item.record.motor_acceleration
    moved = np.zeros_like(motion)
    moved[round(0.5 * item.record.sample_rate_hz) :] = motion[
        : -round(0.5 * item.record.sample_rate_hz)
    ]
    expected = np.fft.rfft(moved, axis=0).T / np.sqrt(len(moved))
    bins = np.rint(item.omega.ravel() / (2 * np.pi) * len(moved) / item.record.sample_rate_hz)
    found = driven_motion(item, late)
    np.testing.assert_allclose(
        found.acceleration,
        expected[:, bins.astype(int)],
        atol=0.01 * np.abs(expected).max(),
    )
    assert driven_motion(item, plain).tail is item.tail
