"""Second-order motion against the nonlinear plant of the emulator, which is checked on its own."""

import dataclasses

import numpy as np
from scipy.interpolate import make_interp_spline

from abb_emulator.mechanics.arm import Arm
from model_gap.campaign.campaign import GapRecord
from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.campaign.spectra import Band, record_spectra
from model_gap.cell.cell_model import CellModel
from model_gap.cell.changes import gain_step
from model_gap.predict.linearised import linearised
from model_gap.predict.predict import Predictor
from structural_model import load_layout, load_robot

RATE_HZ = 2048.0
KEPT = 4
SEED = 12
BAND = Band(4.0, 50.0)


def shaken(model, channels, pose, peak_deg_s2, seconds=5.0):
    """Return a recording of the nonlinear arm: three sines per joint, faded in from rest."""
    rng = np.random.default_rng(SEED)
    time = (np.arange(round(seconds * RATE_HZ)) + 1) / RATE_HZ
    u = np.minimum(time / 0.5, 1.0)[:, None]
    fade = u**4 * (35 - 84 * u + 70 * u * u - 20 * u**3)
    position = np.zeros((len(time), 6))
    for _ in range(3):
        omega, phase = 2 * np.pi * rng.uniform(5, 30, 6), rng.uniform(0, 6, 6)
        size = np.radians(peak_deg_s2) / 3.0 / omega**2
        position += fade * size * (np.sin(omega * time[:, None] + phase) - np.sin(phase))
    smooth = make_interp_spline(time, position, 7)
    rate, rise = smooth.derivative(1)(time), smooth.derivative(2)(time)
    arm = Arm(model, channels, pose, 1 / RATE_HZ)
    blocks = range(0, len(time), 256)
    parts = [
        arm.advance(pose + position[i : i + 256], rate[i : i + 256], rise[i : i + 256])
        for i in blocks
    ]
    readings = np.concatenate([part.readings for part in parts])
    kept = slice(None, None, KEPT)
    return GapRecord(
        'shaken', pose, '1', RATE_HZ / KEPT, readings[kept], rise[kept], rate[kept], position[kept]
    )


def errors(model, cell, records, *, hanging):
    spectra = [record_spectra(item, BAND) for item in records]
    predicted = Predictor(model, spectra, hanging=hanging).predict(cell)
    return [
        float(np.linalg.norm(item.measured - found) / np.linalg.norm(item.measured))
        for item, found in zip(spectra, predicted, strict=True)
    ]


def test_the_nonlinear_arm_is_predicted_far_better_without_its_second_order():
    model = load_robot('generic_arm_6')
    channels = load_layout('generic_arm_6', 'sensors').channels
    pose = model.pose(next(iter(model.poses_controller_rad)))
    cell = CellModel(explicit_damping(model.spec), channels)
    gentle, record = (shaken(model, channels, pose, size) for size in (10.0, 200.0))
    floor = errors(model, cell, [gentle], hanging=True)[0]  # of the discretisation
    raw = errors(model, cell, [record], hanging=True)[0]
    upright = errors(model, cell, [record], hanging=False)[0]
    linear = linearised([record], model, cell, BAND.high_hz)
    found = errors(model, cell, linear, hanging=True)[0]
    text = f'seed {SEED}: floor {floor:.5f}, raw {raw:.5f}, upright {upright:.5f}, {found:.5f}'
    assert upright > 2.0 * raw > 4.0 * floor, text
    assert found**2 - floor**2 < 0.02 * (raw**2 - floor**2), text


def test_what_is_taken_out_grows_with_the_square_of_the_motion():
    model = load_robot('generic_arm_6')
    channels = load_layout('generic_arm_6', 'sensors').channels
    pose = model.pose(next(iter(model.poses_controller_rad)))
    cell = CellModel(explicit_damping(model.spec), channels)
    record = shaken(model, channels, pose, 60.0, seconds=2.0)
    half = dataclasses.replace(
        record,
        motor_acceleration=0.5 * record.motor_acceleration,
        motor_velocity=0.5 * record.motor_velocity,
        motor_shift=0.5 * record.motor_shift,
    )
    taken = [
        item.acceleration - small.acceleration
        for item, small in zip(
            (record, half), linearised([record, half], model, cell, 60.0), strict=True
        )
    ]
    np.testing.assert_allclose(taken[0], 4.0 * taken[1], atol=0.02 * np.abs(taken[0]).max())


def test_what_is_taken_out_is_read_by_the_sensors_as_they_are():
    model = load_robot('generic_arm_6')
    channels = load_layout('generic_arm_6', 'sensors').channels
    pose = model.pose(next(iter(model.poses_controller_rad)))
    cell = CellModel(explicit_damping(model.spec), channels)
    record = shaken(model, channels, pose, 60.0, seconds=2.0)
    row = len(channels) - 1
    upside_down = cell.then_output(gain_step(row, -1.0))
    taken, turned = (
        record.acceleration - linearised([record], model, it, 60.0)[0].acceleration
        for it in (cell, upside_down)
    )
    sign = np.where(np.arange(len(channels)) == row, -1.0, 1.0)
    assert np.abs(taken[:, row]).max() > 1e-4
    np.testing.assert_allclose(turned, taken * sign, atol=1e-12 * np.abs(taken).max())
