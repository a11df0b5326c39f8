"""A record may be cut off while everything moves, at any rate of its samples."""

import dataclasses

import numpy as np
import pytest
from scipy.signal import lsim

from model_gap.campaign import Band, GapRecord, record_spectra
from model_gap.cell import CellModel, pose_system
from model_gap.predict import Predictor
from structural_model.description import CableSpec
from test.support.hidden_campaign import excitation

FINE_HZ, DURATION_S, SEED = 8000, 6.0, 41
POSE = np.array([0.3, 0.2, 0.1, 0.4, -0.6, 0.2])


@pytest.fixture(scope='module')
def light(robot):
    """Return the arm with a quarter of its damping: it rings for longer."""
    damping = robot.spec.damping
    less = dataclasses.replace(
        damping,
        mass_proportional_1_s=0.25 * damping.mass_proportional_1_s,
        stiffness_proportional_s=0.25 * damping.stiffness_proportional_s,
    )
    return dataclasses.replace(robot, spec=dataclasses.replace(robot.spec, damping=less))


@pytest.fixture(scope='module')
def held(light):
    """Return that arm held by a hose: where its motors stand pushes it too."""
    hose = CableSpec('hose', 'link_3', (0.1, 0.2, 0.1), (1.5, 1.0, 2.5), 4e5)
    return dataclasses.replace(light, spec=dataclasses.replace(light.spec, cables=(hose,)))


def shaken(arm_model, layout):
    """Return motors' acceleration and shift, and readings, of an arm that shakes to the end."""
    samples = round(2 * DURATION_S * FINE_HZ)
    motion = excitation(np.random.default_rng(SEED), samples, FINE_HZ, 1.0)
    acceleration, velocity, shift = (values[: samples // 2] for values in motion)
    system = pose_system(arm_model, POSE, layout.channels)
    arm = system.arm
    size = len(arm.M)
    inverse = np.linalg.inv(arm.M)
    state = np.block(
        [[np.zeros((size, size)), np.eye(size)], [-inverse @ arm.K, -inverse @ arm.C]]
    )
    push = (acceleration @ arm.inertia_input.T + shift @ arm.shift_input.T) @ inverse.T
    drive = np.vstack([np.zeros((size, size)), np.eye(size)])
    time = np.arange(len(push)) / FINE_HZ
    _, _, moved = lsim((state, drive, np.eye(2 * size), np.zeros((2 * size, size))), push, time)
    rise = moved @ state[size:].T + push
    reading = (
        rise @ system.flexible.T
        + moved[:, :size] @ system.gravity.T
        + acceleration @ system.rigid.T
        + shift @ system.rigid_gravity.T
    )
    return acceleration, velocity, shift, reading


@pytest.fixture(scope='module')
def shaken_light(light, layout):
    return shaken(light, layout)


@pytest.mark.parametrize('rate_hz', [400, 500, 1000])
def test_what_rings_when_a_record_is_cut_off_is_known_at_any_rate(
    shaken_light, light, layout, rate_hz
):
    check(light, layout, shaken_light, rate_hz)


def test_so_it_is_where_the_place_of_the_motors_pushes_the_arm(held, layout):
    check(held, layout, shaken(held, layout), 500)


def check(arm_model, layout, motion, rate_hz):
    acceleration, velocity, shift, reading = (item[:: FINE_HZ // rate_hz] for item in motion)
    record = GapRecord(
        name='cut off',
        pose=POSE,
        level='1',
        sample_rate_hz=float(rate_hz),
        acceleration=reading,
        motor_acceleration=acceleration,
        motor_velocity=velocity,
        motor_shift=shift,
    )
    item = record_spectra(record, Band(4.0, 50.0))
    cell = CellModel(arm_model.spec, layout.channels)
    (predicted,) = Predictor(arm_model, [item]).predict(cell)
    size = np.linalg.norm(item.measured, axis=0)
    error = np.linalg.norm(item.measured - predicted, axis=0) / size
    worst = int(np.argmax(error))
    assert error[worst] < 0.002, f'{error[worst]:.3f} at {item.frequency_hz[worst]:.2f} Hz'
