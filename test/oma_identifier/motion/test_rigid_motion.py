"""A robot that moves: rigid motion makes no mode, and the right modes stay."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.measurements import JointSamples
from modal_core.numbers.indicators import mac
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.samples import Samples
from modal_core.window import Pose, Window
from oma_identifier.identify import identify_samples
from oma_identifier.motion.joint_motion import joint_motion
from oma_identifier.motion.rigid_motion import LATE, RigidMotionRemoval
from oma_identifier.motion.robot_signals import RobotSignals
from oma_identifier.motion.sensor_check import POLARITY
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings

pytest.importorskip('pinocchio')
robot_files = pytest.importorskip('structural_model.robot_files')
load_layout, load_robot = robot_files.load_layout, robot_files.load_robot

START = 1_700_000_000_000_000_000
RATE_HZ, JOINT_RATE_HZ, DURATION_S = 256.0, 250.0, 60.0
NOISE = 0.01
ENCODER_RAD = 1e-6
SETTINGS = IdentificationSettings(window_s=60.0, max_frequency_hz=50.0)
SEED = 3


@pytest.fixture(scope='module')
def robot():
    return load_robot('irb6660_205_190')


@pytest.fixture(scope='module')
def layout():
    return load_layout('irb6660_205_190')


class Motion:
    """A slow sweep of all joints with fast motion on top, known in closed form."""

    def __init__(self, rest, fast_rad_s2, seed, n_joints=6):
        rng = np.random.default_rng(seed)
        slow = np.array([0.07, 0.31, 1.3, 3.1])
        terms = []
        for joint in range(n_joints):
            for hz, size in zip(slow, (0.25, 0.05, 0.01, 0.003), strict=True):
                terms.append((joint, hz * (1 + 0.07 * joint), size, rng.uniform(0, 2 * np.pi)))
            for hz in rng.uniform(4.0, 40.0, 60) if fast_rad_s2 else ():
                size = fast_rad_s2 / (2 * np.pi * hz) ** 2 / np.sqrt(30.0)
                terms.append((joint, hz, size, rng.uniform(0, 2 * np.pi)))
        self.rest, self.terms = rest, terms

    def at(self, time):
        q, qd, qdd = (np.zeros((len(time), len(self.rest))) for _ in range(3))
        for joint, hz, size, phase in self.terms:
            w = 2 * np.pi * hz
            q[:, joint] += size * (np.sin(w * time + phase) - np.sin(phase))
            qd[:, joint] += size * w * np.cos(w * time + phase)
            qdd[:, joint] -= size * w**2 * np.sin(w * time + phase)
        return q + self.rest, qd, qdd


def times(rate_hz):
    return np.arange(round(DURATION_S * rate_hz)) / rate_hz


def joint_states(robot, position, rng):
    stamps = START + np.round(times(JOINT_RATE_HZ) * 1e9).astype(np.int64)
    noisy = position + ENCODER_RAD * rng.standard_normal(position.shape)
    return JointSamples(stamps, robot.joint_names, noisy, np.full_like(noisy, np.nan))


def window(readings, channels, joints, rng):
    noisy = readings + NOISE * rng.standard_normal(readings.shape)
    pose = Pose(joints.joint_names, joints.position.mean(axis=0), np.ptp(joints.position, axis=0))
    quality = DataQuality(channels=tuple(ChannelQuality(channel.name) for channel in channels))
    samples = Samples(noisy, RATE_HZ, channels, START)
    return Window(0, samples, quality, pose=pose, joints=joints)


def test_derivatives_against_a_known_motion():
    rng = np.random.default_rng(SEED)
    motion = Motion(np.zeros(2), 0.0, SEED, n_joints=2)
    stamps = START + np.round(times(JOINT_RATE_HZ) * 1e9).astype(np.int64)
    q, qd, qdd = motion.at(times(JOINT_RATE_HZ))
    noisy = q + ENCODER_RAD * rng.standard_normal(q.shape)
    found = joint_motion(stamps, noisy, START)
    inside = slice(100, -100)
    for got, true, share in (
        (found.position, q, 1e-5),
        (found.velocity, qd, 1e-3),
        (found.acceleration, qdd, 5e-3),
    ):
        error = np.sqrt(np.mean((got[inside] - true[inside]) ** 2))
        assert error < share * true.std(), f'seed {SEED}'
    # Two plain differences of the same noise are worse than the motion itself.
    naive = np.gradient(np.gradient(noisy, axis=0), axis=0) * JOINT_RATE_HZ**2
    ours = np.std(found.acceleration[inside] - qdd[inside])
    assert np.std(naive[inside] - qdd[inside]) > 3 * ours
    # Ends spoil no more than a tenth of a second.
    assert np.abs(found.acceleration - qdd)[25:-25].max() < 0.1 * qdd.std()


@pytest.mark.parametrize('fast_rad_s2', [pytest.param(0.0, marks=pytest.mark.slow), 1.0])
@pytest.mark.slow
def test_a_rigid_arm_in_motion_has_no_modes(robot, layout, fast_rad_s2):
    for seed in (SEED, SEED + 1):
        rng = np.random.default_rng(seed)
        motion = Motion(robot.pose('P1'), fast_rad_s2, seed)
        readings = robot.rigid_acceleration(*motion.at(times(RATE_HZ)), layout.channels)
        joints = joint_states(robot, motion.at(times(JOINT_RATE_HZ))[0], rng)
        seen = window(readings, layout.channels, joints, rng)
        result = IdentificationPipeline(SETTINGS, robot=robot).identify(seen)
        assert result.modes.frequency_hz.tolist() == [], f'seed {seed}'
        assert 'rigid_motion_removed' in result.quality.flags
        # The fixed base stays; on the arm most of the motion is gone.
        left = RigidMotionRemoval(robot).remove(seen.samples, joints).samples.acceleration
        before = seen.samples.acceleration.std(axis=0)
        moved = before > 10 * NOISE
        assert moved.sum() > 30
        assert np.all(left.std(axis=0)[moved] < 0.1 * before[moved]), f'seed {seed}'


@pytest.mark.parametrize(('scale', 'explained'), [(1.0, True), (0.002, False)])
def test_only_a_travelling_arm_has_peaks_of_motion(robot, layout, scale, explained):
    # Shaking in place, the responses of modes follow the joints: that is how they are excited.
    rng = np.random.default_rng(SEED)
    motion = Motion(np.zeros(6), 0.0, SEED)
    motion.terms = [(joint, hz, scale * size, phase) for joint, hz, size, phase in motion.terms]
    readings = motion.at(times(RATE_HZ))[2][:, :3]
    channels = layout.channels[:3]
    joints = joint_states(robot, motion.at(times(JOINT_RATE_HZ))[0], rng)
    seen = window(readings / readings.std(), channels, joints, rng)
    shape = np.array([1.0, 0.0, 0.0], dtype=complex)
    assert RobotSignals().clean(seen).explains(1.3, 0.05, shape) is explained


@pytest.mark.slow
def test_without_a_model_large_motion_makes_no_mode(robot, layout):
    rng = np.random.default_rng(SEED)
    motion = Motion(robot.pose('P1'), 1.0, SEED)
    readings = robot.rigid_acceleration(*motion.at(times(RATE_HZ)), layout.channels)
    joints = joint_states(robot, motion.at(times(JOINT_RATE_HZ))[0], rng)
    seen = window(readings, layout.channels, joints, rng)
    plain = replace(SETTINGS, refine=False)
    assert len(identify_samples(seen.samples, plain).modes), 'the motion alone looks like modes'
    result = IdentificationPipeline(SETTINGS).identify(seen)
    assert result.modes.frequency_hz.tolist() == [], f'seed {SEED}'
    assert 'gross_motion' in result.quality.flags


def excitation(time, seed, n_joints=6):
    """Return joint departures and accelerations of even power from 3 to 110 Hz."""
    rng = np.random.default_rng(seed)
    position, acceleration = np.zeros((len(time), n_joints)), np.zeros((len(time), n_joints))
    for hz in rng.uniform(3.0, 110.0, 2000):
        # From rest, so that nothing drifts.
        w, size = 2 * np.pi * hz, 0.05 * rng.standard_normal(n_joints)
        position += size / w**2 * (1.0 - np.cos(w * time[:, None]))
        acceleration += size * np.cos(w * time[:, None])
    return position, acceleration


LATE_SENSOR, LATE_SAMPLES = 'elbow_top', 1


@pytest.fixture(scope='module')
def shaken(robot, layout):
    """Return readings of a flexible arm, shaken while all joints travel far, and its joints.

    The flexible part is that of the resting pose, so that there is one truth; a quarter of a
    radian and more of travel turns gravity by many times the vibrations.
    """
    rest, channels = robot.pose('P1'), layout.channels
    sweep = Motion(rest, 0.0, SEED)
    shake = excitation(times(RATE_HZ), SEED)[1]
    vibration = robot.time_response(rest, channels, shake, RATE_HZ).output
    readings = vibration + robot.rigid_acceleration(*sweep.at(times(RATE_HZ)), channels)
    late = [n for n, channel in enumerate(channels) if channel.name.startswith(LATE_SENSOR)]
    readings[LATE_SAMPLES:, late] = readings[:-LATE_SAMPLES, late]
    at_joints = sweep.at(times(JOINT_RATE_HZ))[0] + excitation(times(JOINT_RATE_HZ), SEED)[0]
    return readings, at_joints


@pytest.mark.parametrize(
    ('modelled', 'early_s'),
    [
        (True, 0.03),
        pytest.param(True, -0.2, marks=pytest.mark.slow),
        pytest.param(False, 0.0, marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_a_flexible_arm_keeps_its_modes_in_motion(robot, layout, shaken, modelled, early_s):
    """No mode is lost, none is added: with a model, without, and with joint states out of step."""
    rng = np.random.default_rng(SEED)
    readings, at_joints = shaken
    joints = joint_states(robot, at_joints, rng)
    joints = replace(joints, stamp_ns=joints.stamp_ns - round(early_s * 1e9))
    seen = window(readings, layout.channels, joints, rng)
    result = IdentificationPipeline(SETTINGS, robot=robot if modelled else None).identify(seen)
    truth = robot.damped_modes(robot.pose('P1'), layout.channels)
    expected = truth.frequency_hz[truth.frequency_hz < 45.0]
    assert result.modes.frequency_hz == pytest.approx(expected, rel=0.015), f'seed {SEED}'
    assert 'gross_motion' in result.quality.flags
    if not modelled:
        return
    assert 'rigid_motion_removed' in result.quality.flags
    removal = RigidMotionRemoval(robot).remove(seen.samples, joints)
    fit = removal.fit
    assert abs(fit.common_lag_s - early_s) < 3.0 * fit.common_lag_std_s < 1.5e-3, f'seed {SEED}'
    assert 4.0 < fit.reach_hz < expected[0], 'rigid motion ends below the first mode'
    assert removal.flags == {f'{LATE_SENSOR}.{axis}': LATE for axis in 'xyz'}
    reported = {c.lag_s for c in result.quality.channels if LATE in c.flags}
    assert reported == {removal.lags[f'{LATE_SENSOR}.x'].seconds}
    lag = removal.lags[f'{LATE_SENSOR}.x']
    assert lag.behind_s == pytest.approx(LATE_SAMPLES / RATE_HZ, abs=5e-4)
    # Put right, the shapes are those of sensors that were sampled together.
    for mode, exact in zip(result.modes, truth.channel_shapes.T, strict=False):
        assert mac(mode.shape, exact)[0, 0] > 0.97, mode.frequency_hz

    def slow(data):
        return data[256:].reshape(-1, 256, data.shape[1]).mean(axis=1).std()

    left = removal.samples.acceleration
    assert slow(left) < 0.1 * slow(seen.samples.acceleration), 'slow motion is left'


def test_a_sensor_that_does_not_fit_the_model_is_left_alone_and_named(robot, layout):
    rng = np.random.default_rng(SEED)
    motion = Motion(robot.pose('P1'), 0.0, SEED)
    readings = robot.rigid_acceleration(*motion.at(times(RATE_HZ)), layout.channels)
    joints = joint_states(robot, motion.at(times(JOINT_RATE_HZ))[0], rng)
    flipped = layout.channels[-1].name
    readings[:, -1] *= -1.0
    seen = window(readings, layout.channels, joints, rng)
    removal = RigidMotionRemoval(robot).remove(seen.samples, joints)
    assert removal.flags == {flipped: POLARITY}
    assert np.array_equal(removal.samples.acceleration[:, -1], seen.samples.acceleration[:, -1])


@pytest.mark.slow
def test_windows_that_overlap_are_predicted_once_and_alike(robot, layout):
    rng = np.random.default_rng(SEED)
    motion = Motion(robot.pose('P1'), 1.0, SEED)
    readings = robot.rigid_acceleration(*motion.at(times(RATE_HZ)), layout.channels)
    joints = joint_states(robot, motion.at(times(JOINT_RATE_HZ))[0], rng)
    whole = window(readings, layout.channels, joints, rng).samples
    removal = RigidMotionRemoval(robot)
    half = round(20.0 * RATE_HZ)

    def part(first):
        rows = whole.acceleration[first : first + 2 * half]
        return replace(whole, acceleration=rows, start_ns=START + round(first / RATE_HZ * 1e9))

    removal.remove(part(0), joints)
    later = removal.remove(part(half), joints).samples.acceleration
    alone = RigidMotionRemoval(robot).remove(part(half), joints).samples.acceleration
    assert np.abs(later - alone).max() < 0.1 * NOISE


def test_joint_states_that_stop_are_not_believed(robot, layout):
    rng = np.random.default_rng(SEED)
    motion = Motion(robot.pose('P1'), 0.0, SEED)
    readings = robot.rigid_acceleration(*motion.at(times(RATE_HZ)), layout.channels)
    joints = joint_states(robot, motion.at(times(JOINT_RATE_HZ))[0], rng)
    first = JointSamples(
        joints.stamp_ns[:9000], joints.joint_names, joints.position[:9000], joints.velocity[:9000]
    )
    seen = window(readings, layout.channels, first, rng)
    removal = RigidMotionRemoval(robot).remove(seen.samples, first)
    assert removal.motion is None and removal.samples is seen.samples
