"""The plant against known truth: equilibrium, modes, the structural model's own response."""

import numpy as np
import pytest

from robot_bridge.emulator.arm import Arm
from robot_bridge.emulator.gear_torque import GearSettings
from robot_bridge.emulator.rigid_sensors import RigidSensors
from structural_model import load_layout, load_robot

RATE_HZ = 2048.0


@pytest.fixture(scope='module')
def model():
    return load_robot('irb6660_205_190')


@pytest.fixture(scope='module')
def channels():
    return load_layout('irb6660_205_190', 'sensors').channels


def still(pose, n):
    return np.tile(pose, (n, 1)), np.zeros((n, 6)), np.zeros((n, 6))


def test_at_rest_it_reads_gravity_and_nothing_moves(model, channels):
    pose = model.pose('P1')
    arm = Arm(model, channels, pose, 1 / RATE_HZ)
    found = arm.advance(*still(pose, 512))
    assert np.ptp(found.readings, axis=0).max() < 1e-9
    magnitude = np.linalg.norm(found.readings[0].reshape(-1, 3), axis=1)
    np.testing.assert_allclose(magnitude, 9.81, rtol=1e-3)


def test_rigid_sensors_agree_with_the_structural_model(model, channels):
    random = np.random.default_rng(4)
    motion = [random.normal(size=(40, 6)) for _ in range(3)]
    np.testing.assert_allclose(
        RigidSensors(model, channels).readings(*motion),
        model.rigid_acceleration(*motion, channels),
        atol=1e-11,
    )


def test_free_decay_has_the_true_poles(model, channels):
    pose = model.pose('P3')
    arm = Arm(model, channels, pose, 1 / RATE_HZ)
    truth = model.damped_modes(pose)
    n_dof = model.n_dof
    for index in range(4):
        pole = truth.poles_1_s[index]
        shape = truth.shapes[:, index]
        rest = arm._state.copy()
        kick = np.concatenate([shape.real, (pole * shape).real])
        arm._state = rest + 1e-6 * kick / np.abs(kick[:n_dof]).max()
        start = arm._state - rest
        n = 600
        arm.advance(*still(pose, n))
        end = arm._state - rest
        factor = np.exp(pole * n / RATE_HZ)
        scale = 1e-6 / np.abs(kick[:n_dof]).max()
        expected = scale * np.concatenate([(factor * shape).real, (pole * factor * shape).real])
        np.testing.assert_allclose(end, expected, atol=1e-9 * np.abs(start).max())
        arm._state = rest


def test_forced_response_is_that_of_the_accelerance(model, channels):
    """A steady sine of one motor gives J (M_r-driven flexible + rigid) at that frequency."""
    pose, hz, axis = model.pose('P1'), 15.0, 1
    arm = Arm(model, channels, pose, 1 / RATE_HZ)
    omega = 2 * np.pi * hz
    time = np.arange(1, int(8 * RATE_HZ) + 1) / RATE_HZ
    amplitude = 1e-5
    unit = np.eye(6)[axis]
    q = pose + amplitude * np.sin(omega * time)[:, None] * unit
    qd = amplitude * omega * np.cos(omega * time)[:, None] * unit
    qdd = -amplitude * omega**2 * np.sin(omega * time)[:, None] * unit
    blocks = [arm.advance(q[i : i + 256], qd[i : i + 256], qdd[i : i + 256]).readings
              for i in range(0, len(time), 256)]  # fmt: skip
    readings = np.concatenate(blocks)[-int(4 * RATE_HZ) :]
    tail = time[-int(4 * RATE_HZ) :]
    window = np.hanning(len(tail))
    found = (
        2 * (window * np.exp(-1j * omega * tail)) @ (readings - readings.mean(0)) / window.sum()
    )
    matrices = model.matrices(pose)
    dynamic = matrices.K - omega**2 * matrices.M + 1j * omega * matrices.C
    drive = -1j * amplitude * unit  # sin as the real part of -j exp
    load = model.input_matrix(pose) @ (-(omega**2) * drive) - model.gravity_coupling(pose) @ drive
    flexible = np.linalg.solve(dynamic, load)
    expected = model.sensor_jacobian(pose, channels) @ (-(omega**2) * flexible)
    expected += model.rigid_jacobian(pose, channels) @ (-(omega**2) * drive)
    largest = np.abs(expected).max()
    # The tilt of the sensors in gravity, 9.81 / ω² of the motion, is left out of ``expected``.
    np.testing.assert_allclose(found, expected, atol=5e-3 * largest)


def test_nonlinear_gears_without_any_nonlinearity_are_linear(model, channels):
    pose = model.pose('P1')
    random = np.random.default_rng(2)
    motion = (np.tile(pose, (256, 1)), np.zeros((256, 6)), random.normal(size=(256, 6)))
    tiny = GearSettings(hardening_1_rad2=(1e-9,) * 6)
    linear = Arm(model, channels, pose, 1 / RATE_HZ).advance(*motion)
    same = Arm(model, channels, pose, 1 / RATE_HZ, tiny).advance(*motion)
    np.testing.assert_allclose(same.readings, linear.readings, atol=1e-8)


def test_friction_takes_energy_out(model, channels):
    pose = model.pose('P1')
    rub = GearSettings(friction_nm=(50.0,) * 6)
    ends = []
    for gears in (None, rub):
        arm = Arm(model, channels, pose, 1 / RATE_HZ, gears)
        kick = np.zeros((64, 6))
        kick[:, 1] = 2.0
        arm.advance(np.tile(pose, (64, 1)), np.zeros((64, 6)), kick)
        ends.append(arm.advance(*still(pose, 1024)).readings[-256:].std(axis=0).max())
    assert ends[1] < 0.7 * ends[0]
