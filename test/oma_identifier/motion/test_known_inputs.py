"""Combined identification on the emulated arm: what the joints do is known, and that counts."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.errors import IdentificationError
from modal_core.measurements import JointSamples
from modal_core.samples import Samples
from modal_core.window import Window
from oma_identifier.motion.joint_motion import joint_motion
from oma_identifier.motion.known_inputs import with_inputs
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.record.kept_record import KeptRecord
from oma_identifier.settings import IdentificationSettings

pytest.importorskip('pinocchio')
robot_files = pytest.importorskip('structural_model.robot_files')
from abb_emulator.drives.servo import Servo, ServoSettings  # noqa: E402
from abb_emulator.mechanics.arm import Arm  # noqa: E402

START = 1_700_000_000_000_000_000
RATE_HZ, DURATION_S, BLOCK = 512.0, 26.0, 64
JOINT_EVERY = 2
"""Steps of the plant from one joint state to the next: 256 Hz."""
NOISE = 3e-3
SEED = 11


@pytest.fixture(scope='module')
def robot():
    return robot_files.load_robot('irb6660_205_190')


@pytest.fixture(scope='module')
def recorded(robot):
    """Return one window of an emulated arm whose drives follow small random commands."""
    rng = np.random.default_rng(SEED)
    channels = robot_files.load_layout('irb6660_205_190', 'sensors_light').channels
    pose = robot.pose('P1')
    start_deg = np.degrees(robot.to_controller(pose))
    n = int(DURATION_S * RATE_HZ) // BLOCK * BLOCK
    spectrum = np.fft.rfft(rng.standard_normal((n, 6)), axis=0)
    hz = np.fft.rfftfreq(n, 1.0 / RATE_HZ)[:, None]
    shaped = np.where((hz > 4.0) & (hz < 70.0), 1.0 / np.maximum(hz, 1.0) ** 2, 0.0)
    command = np.fft.irfft(spectrum * shaped, n, axis=0)
    # Encoders count 4e-6 rad: the motion must be many counts at the highest mode.
    command *= np.minimum(np.arange(n) / RATE_HZ, 1.0)[:, None] * 0.05 / command.std()
    servo = Servo(ServoSettings(), start_deg, 1.0 / RATE_HZ)
    arm = Arm(robot, channels, pose, 1.0 / RATE_HZ)
    to_serial = np.linalg.inv(robot.axes.matrix).T
    readings, angles = [], []
    count = 360.0 / (servo.settings.encoder_counts * np.array(servo.settings.gear_ratio))
    for first in range(0, n, BLOCK):
        motion = servo.advance(start_deg + command[first : first + BLOCK])
        angles.append(np.round(motion.position_deg / count) * count)
        parts = (motion.position_deg, motion.velocity_deg_s, motion.acceleration_deg_s2)
        done = arm.advance(*(np.radians(part) @ to_serial for part in parts))
        readings.append(done.readings)
    data = np.concatenate(readings)
    data += NOISE * rng.standard_normal(data.shape)
    stamps = START + np.round(np.arange(n) / RATE_HZ * 1e9).astype(np.int64)
    position = np.radians(np.concatenate(angles)) @ to_serial
    kept = slice(0, n, JOINT_EVERY)
    joints = JointSamples(
        stamps[kept], robot.joint_names, position[kept], np.full_like(position[kept], np.nan)
    )
    # The first two seconds build up.
    first = int(2.0 * RATE_HZ)
    samples = Samples(data[first:], RATE_HZ, channels, int(stamps[first]))
    return Window(0, samples, joints=joints)


def errors(robot, window, method):
    """Return the relative errors of the modes below 45 Hz, (2, n) for frequency and damping."""
    settings = IdentificationSettings(window_s=24.0, max_frequency_hz=50.0, method=method)
    modes = IdentificationPipeline(settings, robot=robot).identify(window).modes
    truth = robot.damped_modes(robot.pose('P1'))
    wanted = truth.frequency_hz < 45.0
    found = []
    for hz, damping in zip(truth.frequency_hz[wanted], truth.damping_ratio[wanted], strict=True):
        mode = min(modes, key=lambda one: abs(one.frequency_hz - hz), default=None)
        assert mode is not None and abs(mode.frequency_hz / hz - 1.0) < 0.03, f'{method}: {hz}'
        found.append((mode.frequency_hz / hz - 1.0, mode.damping_ratio / damping - 1.0))
    assert len(modes) == len(found), f'{method}: {modes.frequency_hz}'
    return np.array(found).T


@pytest.mark.slow
def test_known_joint_motion_makes_modes_several_times_more_exact(robot, recorded):
    blind = np.sqrt(np.mean(errors(robot, recorded, 'ssi_cov') ** 2, axis=1))
    known = np.sqrt(np.mean(errors(robot, recorded, 'csi') ** 2, axis=1))
    print(f'seed {SEED}: rms error of frequency and damping, blind {blind}, known {known}')
    assert np.all(known < 0.25 * blind), f'seed {SEED}: {known} {blind}'


def test_the_default_method_states_nothing_wrong_with_joint_states(robot, recorded):
    settings = IdentificationSettings(window_s=24.0, max_frequency_hz=50.0)
    result = IdentificationPipeline(settings, robot=robot).identify(recorded)
    truth = robot.damped_modes(robot.pose('P1'))
    assert len(result.modes) >= 5, f'seed {SEED}'
    for mode in result.modes:
        at = int(np.argmin(np.abs(truth.frequency_hz - mode.frequency_hz)))
        off = (mode.frequency_hz - truth.frequency_hz[at]) / mode.frequency_std_hz
        assert abs(off) < 5.0, f'seed {SEED}: {mode.frequency_hz}'


def test_inputs_stay_with_their_samples_in_a_record(recorded):
    samples = recorded.samples
    motion = joint_motion(recorded.joints.stamp_ns, recorded.joints.position, samples.start_ns)
    both = with_inputs(samples, motion, 6)
    kept = KeptRecord(both, 2**30)
    half = len(both.acceleration) // 2
    step_ns = round(half / RATE_HZ * 1e9)
    kept.add(both.part(slice(0, half)))
    kept.add(replace(both.part(slice(half, None)), start_ns=both.start_ns + step_ns))
    (part,) = kept.parts()
    assert part.acceleration.shape == samples.acceleration.shape
    assert np.allclose(part.known, both.known, atol=1e-4 * np.abs(both.known).max())
    kept.add(replace(samples, start_ns=samples.end_ns))
    assert np.isnan(kept.parts()[0].known[len(both.known) :]).all()


def test_csi_without_joint_states_says_what_it_needs(recorded):
    settings = IdentificationSettings(window_s=24.0, max_frequency_hz=50.0, method='csi')
    with pytest.raises(IdentificationError, match='joint states'):
        IdentificationPipeline(settings).identify(replace(recorded, joints=None))
