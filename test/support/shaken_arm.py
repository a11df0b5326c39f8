"""An emulated arm in a random pose, shaken or moved at random, as its sensors record it."""

import numpy as np
from scipy.interpolate import CubicSpline

from abb_emulator.cell import ArmSide, CellSettings
from abb_emulator.drives import Servo, ServoSettings
from abb_emulator.sensing import SensorSettings
from modal_core.measurements import JointSamples, SampleBlock

START = 1_700_000_000_000_000_000
RATE_HZ, BLOCK = 512.0, 64
WARM_S = 2.0


def shaken_arm(robot, channels, seed, duration_s=30.0):
    """Return joint states and one block of samples of a healthy arm.

    Its masses, springs, places and gains are a little off those of the model; sensors have offsets
    of up to 0.5 m/s² in standard deviation.
    """
    rng = np.random.default_rng(seed)
    poses = sorted(robot.poses_controller_rad)
    pose = robot.to_controller(robot.pose(poses[rng.integers(len(poses))]))
    start_deg = np.degrees(pose) + rng.uniform(-25.0, 25.0, 6)
    n = int((duration_s + WARM_S) * RATE_HZ) // BLOCK * BLOCK
    moves = noise if seed % 2 else point_to_point
    command = start_deg + moves(rng, n) * np.minimum(np.arange(n) / RATE_HZ, 1.0)[:, None]
    cell = CellSettings(
        sample_rate_hz=RATE_HZ,
        block_samples=BLOCK,
        seed=seed,
        tolerance=1.0,
        tolerance_seed=seed,
        sensors=SensorSettings(
            bias=10 ** rng.uniform(-2.0, -0.3), noise_density=10 ** rng.uniform(-3.5, -2.0)
        ),
    )
    servo = Servo(ServoSettings(), start_deg, 1.0 / RATE_HZ)
    arm = ArmSide(robot, channels, start_deg, cell)
    to_serial = np.linalg.inv(robot.axes.matrix).T
    count = 360.0 / (servo.settings.encoder_counts * np.array(servo.settings.gear_ratio))
    samples, angles = [], []
    for first in range(0, n, BLOCK):
        motion = servo.advance(command[first : first + BLOCK])
        angles.append(np.radians(np.round(motion.position_deg / count) * count) @ to_serial)
        parts = (motion.position_deg, motion.velocity_deg_s, motion.acceleration_deg_s2)
        moved = tuple(np.radians(part) @ to_serial for part in parts)
        samples += [block.acceleration for block in arm.take(moved)]
    kept = slice(int(WARM_S * RATE_HZ), None, 2)
    position = np.concatenate(angles)[kept]
    stamps = START + np.round(np.arange(n) / RATE_HZ * 1e9).astype(np.int64)
    names = tuple(channel.name for channel in channels)
    values = np.concatenate(samples)[kept.start :]
    return (
        JointSamples(stamps[kept], robot.joint_names, position, np.full_like(position, np.nan)),
        SampleBlock('daq', int(stamps[kept.start]), 0, RATE_HZ, names, values),
    )


def weights(rng):
    """Return how much each axis moves, some not at all."""
    some = np.where(rng.random(6) < 0.7, 10 ** rng.uniform(-1.0, 0.0, 6), 0.0)
    return some if some.any() else np.ones(6)


def noise(rng, n):
    """Return small random motion in a band [deg], (n, 6)."""
    hz = np.fft.rfftfreq(n, 1.0 / RATE_HZ)[:, None]
    inside = (hz > rng.uniform(0.5, 8.0)) & (hz < rng.uniform(30.0, 80.0))
    spectrum = np.fft.rfft(rng.standard_normal((n, 6)), axis=0)
    motion = np.fft.irfft(spectrum * inside / np.maximum(hz, 0.5) ** 2, n, axis=0)
    size = np.diff(motion, 2, axis=0).std(axis=0) * RATE_HZ**2
    return motion * weights(rng) * np.degrees(rng.uniform(0.3, 2.0)) / size


def point_to_point(rng, n):
    """Return moves of up to six degrees with pauses [deg], (n, 6)."""
    reach, now = rng.uniform(0.3, 6.0), 0.0
    times, places = [], []
    place = np.zeros(6)
    while now < n / RATE_HZ:
        times += [now, now + rng.uniform(0.05, 1.0)]
        places += [place, place]
        place = rng.uniform(-reach, reach, 6)
        now = times[-1] + rng.uniform(0.15, 1.0) + np.sqrt(reach / 10.0)
    smooth = CubicSpline(times, np.array(places), axis=0)(np.arange(n) / RATE_HZ)
    return smooth * weights(rng)
