"""Recorder and drives as stated: noise, bias, steps, range, clock; dead time, servo, encoder."""

import numpy as np
import pytest
from scipy.signal import welch

from abb_emulator.cell import ArmSide, CellSettings, MotorSide
from abb_emulator.drives.servo import Servo, ServoSettings
from abb_emulator.sensing.sensors import SensorArray, SensorSettings
from modal_core.channel import Channel
from modal_core.units import ANGULAR_VELOCITY

RATE_HZ = 2048.0
SEED = 21


def recorded(settings, n=40_000, gyro=None, n_channels=8):
    array = SensorArray(settings, n_channels, RATE_HZ, np.random.default_rng(SEED), gyro)
    return array.sample(np.zeros((n, n_channels))).astype(float)


def test_noise_has_the_density_stated_and_is_white():
    density = 3e-4
    data = recorded(SensorSettings(noise_density=density, bias=0.0, resolution=0.0))
    hz, power = welch(data, RATE_HZ, nperseg=1024, axis=0)
    for low, high in ((5, 100), (400, 1000)):
        level = np.sqrt(power[(hz > low) & (hz < high)].mean())
        assert level == pytest.approx(density, rel=0.03), f'seed {SEED}'


def test_bias_is_constant_and_of_the_spread_stated():
    data = recorded(
        SensorSettings(noise_density=0.0, bias=0.02, resolution=0.0), n=4, n_channels=2000
    )
    assert np.ptp(data, axis=0).max() == 0.0
    assert data[0].std() == pytest.approx(0.02, rel=0.05), f'seed {SEED}'


def test_steps_and_range_are_those_of_the_converter():
    limits = SensorSettings(noise_density=0.1, bias=0.0, resolution=0.05, range_limit=3.0)
    data = recorded(limits)
    np.testing.assert_allclose(data / 0.05, np.round(data / 0.05), atol=1e-5)
    assert np.abs(data).max() == pytest.approx(3.0)


def test_gyroscopes_have_a_scale_of_their_own():
    gyro = np.array([False] * 4 + [True] * 4)
    data = recorded(SensorSettings(bias=0.0, resolution=0.0, gyro_scale=0.1), gyro=gyro)
    assert data[:, 4:].std() == pytest.approx(0.1 * data[:, :4].std(), rel=0.02)


def test_a_fast_clock_takes_more_samples_of_the_same_motion(model, start_deg):
    """Stamps are the recorder's own: what differs is how many samples a second has."""
    channel = (Channel('base.x', 'base_link'),)
    n_cycles, counts = 500, {}
    for ppm in (0.0, 20_000.0):
        settings = CellSettings(sensors=SensorSettings(clock_error_ppm=ppm), block_samples=1)
        motors = MotorSide(model, start_deg, None, settings, 0.0)
        arm = ArmSide(model, channel, start_deg, settings)
        counts[ppm] = sum(len(arm.take(motors.cycle())) for _ in range(n_cycles))
    assert counts[0.0] == int(n_cycles * 0.004032 * RATE_HZ)
    assert counts[20_000.0] == int(n_cycles * 0.004032 * RATE_HZ * 1.02)


def test_the_servo_steps_as_second_order_systems_do_after_its_dead_time():
    settings = ServoSettings(bandwidth_hz=12.0, damping_ratio=0.4, dead_time_s=0.05)
    servo = Servo(settings, np.zeros(6), 1.0 / RATE_HZ)
    found = servo.advance(np.ones((2048, 6))).position_deg[:, 0]
    omega, zeta = 2 * np.pi * 12.0, 0.4
    # The command is a straight line to 1 within the first step: half a step late.
    time_s = np.arange(1, 2049) / RATE_HZ - 0.5 / RATE_HZ - round(0.05 * RATE_HZ) / RATE_HZ
    damped = omega * np.sqrt(1 - zeta**2)
    wanted = 1 - np.exp(-zeta * omega * time_s) * (
        np.cos(damped * time_s) + zeta * omega / damped * np.sin(damped * time_s)
    )
    late = time_s > 1.0 / RATE_HZ
    np.testing.assert_allclose(found[late], wanted[late], atol=1e-3)
    assert not found[time_s < -1.0 / RATE_HZ].any()


def test_friction_leaves_the_motor_short_of_its_command():
    rough = ServoSettings(friction_deg_s2=200.0, dead_time_s=0.0)
    servo = Servo(rough, np.zeros(6), 1.0 / RATE_HZ)
    omega = 2 * np.pi * rough.bandwidth_hz
    # Turning steadily, friction is held by the servo's stiffness: lag = friction / ω².
    speed = 20.0
    path = speed * np.arange(1, 4097) / RATE_HZ
    found = servo.advance(np.tile(path[:, None], (1, 6))).position_deg[-1, 0]
    lag = path[-1] - found
    plain = speed * 2 * rough.damping_ratio / omega
    assert lag - plain == pytest.approx(200.0 / omega**2, rel=1e-3)


def test_encoders_count(model, start_deg):
    motors = MotorSide(model, start_deg, None, CellSettings(), 0.0)
    motors.controller.axes.planned_deg += 0.0123456
    for _ in range(40):
        motors.cycle()
    servo = CellSettings().servo
    counts = motors.controller.axes.measured_deg * np.array(servo.gear_ratio) * 8192 / 360.0
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert (
        np.abs(motors.controller.axes.measured_deg - motors.controller.axes.planned_deg).max()
        > 0.0
    )


@pytest.mark.parametrize('unit', [ANGULAR_VELOCITY])
def test_gyroscopes_read_the_turn_of_a_joint(unit, model, start_deg):
    """Axis 1 alone turns a gyroscope on link 1 about z by its own speed."""
    channels = (Channel('frame.gyro_z', 'link_1', (0.0, 0.0, 1.0), unit=unit),)
    quiet = SensorSettings(noise_density=0.0, bias=0.0, resolution=0.0)
    arm = ArmSide(model, channels, start_deg, CellSettings(sensors=quiet))
    n = 2048
    time_s = np.arange(1, n + 1) / RATE_HZ
    rate = 0.2 * (1 - np.cos(2 * np.pi * time_s))
    q = np.tile(arm.pose, (n, 1))
    q[:, 0] += 0.2 * (time_s - np.sin(2 * np.pi * time_s) / (2 * np.pi))
    qd, qdd = np.zeros((n, 6)), np.zeros((n, 6))
    qd[:, 0], qdd[:, 0] = rate, 0.4 * np.pi * np.sin(2 * np.pi * time_s)
    data = np.concatenate([block.acceleration for block in arm.take((q, qd, qdd))])[:, 0]
    # The rest is the arm's own vibration, driven by the turn.
    np.testing.assert_allclose(data, rate, atol=5e-3)
    assert np.ptp(data) > 0.39
