"""How far joints may travel, against the nonlinear plant of the emulator."""

import dataclasses

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from abb_emulator.mechanics.arm import Arm
from model_gap.campaign import Band, Campaign, GapRecord, record_spectra
from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.cell import CellModel
from model_gap.decide import Verdict
from model_gap.find_gap import find_gap
from model_gap.predict import changing, linearised, Predictor
from model_gap.report import summary_lines
from model_gap.travelled import without_travelled
from structural_model import load_layout, load_robot

RATE_HZ = 1024.0
SEED = 23
BAND = Band()
MODEL = load_robot('generic_arm_6')
LAYOUT = load_layout('generic_arm_6', 'sensors')
CHANNELS = LAYOUT.channels
POSE = MODEL.pose(next(iter(MODEL.poses_controller_rad)))
CELL = CellModel(explicit_damping(MODEL.spec), CHANNELS)


def swaying(sway_deg, seconds=6.0):
    """Return a recording of the nonlinear arm: it shakes while joints 2 and 3 sway at 0.3 Hz."""
    rng = np.random.default_rng(SEED)
    time = (np.arange(round(seconds * RATE_HZ)) + 1) / RATE_HZ
    u = np.minimum(np.minimum(time, seconds - time) / 1.0, 1.0)[:, None]
    fade = u**4 * (35 - 84 * u + 70 * u * u - 20 * u**3)
    position = np.zeros((len(time), 6))
    for _ in range(12):
        omega, phase = 2 * np.pi * rng.uniform(4, 50, 6), rng.uniform(0, 6, 6)
        position += (
            fade * np.radians(100.0) / 12.0 / omega**2 * np.sin(omega * time[:, None] + phase)
        )
    sway = np.radians(sway_deg) * np.sin(2 * np.pi * 0.3 * time)
    position[:, 1:3] += fade * sway[:, None]
    smooth = make_interp_spline(time, position, 7)
    rate, rise = smooth.derivative(1)(time), smooth.derivative(2)(time)
    arm = Arm(MODEL, CHANNELS, POSE, 1 / RATE_HZ)
    parts = [
        arm.advance(POSE + position[i : i + 256], rate[i : i + 256], rise[i : i + 256])
        for i in range(0, len(time), 256)
    ]
    readings = np.concatenate([part.readings for part in parts])
    readings += 0.01 * rng.standard_normal(readings.shape)
    kept, mean = slice(None, None, 2), position.mean(axis=0)
    return GapRecord(
        'swaying', POSE + mean, '1', RATE_HZ / 2, readings[kept], rise[kept], rate[kept],
        (position - mean)[kept],
    )  # fmt: skip


def left_over(record):
    """Return χ of the true model about the mean pose."""
    item = record_spectra(linearised([record], MODEL, CELL, BAND.high_hz)[0], BAND)
    (squares,) = Predictor(MODEL, [item]).squares(CELL)
    return float(squares.mean())


@pytest.mark.parametrize(('sway_deg', 'holds'), [(0.0, True), (0.2, True), (4.0, False)])
def test_what_travel_leaves_over_is_told_beforehand(sway_deg, holds):
    record = swaying(sway_deg)
    told, true = changing(record, MODEL, CELL, BAND), left_over(record)
    text = f'seed {SEED}: told {told}, χ {true:.3g}'
    assert np.degrees(told.travel[1]) == pytest.approx(2.0 * sway_deg, rel=0.1, abs=0.05), text
    assert (told.misfit < 0.7) is holds is (true < 1.7), text


def test_shaking_is_no_travel():
    record = swaying(0.0)
    assert changing(record, MODEL, CELL, BAND).misfit == 0.0
    way = np.linspace(-1.0, 1.0, len(record.motor_shift))[:, None] * np.radians(5.0)
    moving = dataclasses.replace(record, motor_shift=record.motor_shift + way)
    told = changing(moving, MODEL, CELL, BAND)
    assert np.degrees(told.travel).max() == pytest.approx(10.0, rel=0.1)


def campaign(*sways_deg):
    records = [dataclasses.replace(swaying(sway), name=f'sway_{sway:g}') for sway in sways_deg]
    return Campaign(tuple(records), LAYOUT, MODEL.joint_names)


def test_a_recording_that_travels_too_far_is_left_out_with_a_note():
    kept, told = without_travelled(MODEL, campaign(0.0, 4.0), BAND)
    assert [item.name for item in kept.records] == ['sway_0'], f'seed {SEED}'
    assert told.names == ('sway_4',) and not told.all_of_them
    assert told.travel == pytest.approx(8.0, rel=0.1) and told.most < 4.0, f'seed {SEED}: {told}'
    (note,) = kept.notes
    assert 'sway_4' in note and note.endswith('left out') and '--' not in note
    same, none = without_travelled(MODEL, campaign(0.0), BAND)
    assert none is None and not same.notes


@pytest.mark.slow
def test_where_all_travel_that_is_the_reason_and_nothing_is_named():
    result = find_gap(MODEL, campaign(4.0))
    decision = result.decision
    assert decision.verdict is Verdict.UNEXPLAINED, f'seed {SEED}: {decision}'
    assert decision.reasons[0].startswith('the joints travel too far'), f'seed {SEED}'
    assert result.faults_at_rest == () and result.calibrated is None, f'seed {SEED}'
    (following,) = decision.experiments
    assert 'may travel' in following and 'amplitude' not in following
    assert summary_lines(result)[0].startswith('unexplained: The joints travel too far')
