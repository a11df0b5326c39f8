"""The emulated arm mills at rest in a pose: its record, its own modes, and where lines stand.

The spindle is unbalanced, one of its bearings pushes at an order that lies 1 % above a mode, and
the cutter has runout.  Unbalance, bearing and depth of cut are chosen by a first, short record
such that their lines stand 20 to 40 dB above what breaking chips shake; what the lines of the
record itself do is measured again.  The arm stands still before: that the spindle pushes from the
first sample on leaves a free decay of every mode.

The arm has modes up to 490 Hz, the cut lines without end.  As a recorder does, the plant is
sampled faster and filtered before its record is: unfiltered, modes of 156 to 176 Hz and of 357 to
425 Hz would stand at 80 to 104 Hz, where nobody could tell them from the arm's own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import resample_poly

from abb_emulator.cell import ArmSide, CellSettings
from abb_emulator.process import ProcessLine, ProcessSettings, SpindleProcess
from modal_core.samples import Samples
from structural_model.robot_files import load_layout, load_robot

ROBOT, POSES = 'irb6660_205_190', ('P1', 'P2', 'P3')
POSE_RAD = 0.15
"""Every joint of a named pose is turned by at most so much."""
RATE_HZ, DURATION_S, TRIAL_S = 256.0, 120.0, 20.0
OVERSAMPLED = 3
"""Modes below 640 Hz fold to where the filter stops."""
EVERY_SENSOR = 3
"""Of the sensors of the robot one in so many is recorded: five with three axes."""
HIGHEST_HZ, LEAST_CYCLES = 60.0, 2.0
"""Modes asked for: below, and ζ f T above."""
SPEEDS_RPM = (1140.0, 1560.0, 2100.0)
NEAR, NEAR_HZ = 1.01, (8.0, 45.0)
LEVEL_DB, AROUND_HZ = (20.0, 40.0), 0.5
"""Highest line of unbalance, bearing, and cut; power over that of chips within so much."""
CUT = ProcessSettings(n_teeth=2, feed_mm=0.03, runout_um=8.0, regeneration=False)
CHIPS_N = 12.0 * math.sqrt(OVERSAMPLED)
"""White up to half the plant's rate."""
Real = NDArray[np.float64]


@dataclass(frozen=True)
class Scene:
    """A record of the milling arm with what is true.

    Parameters
    ----------
    samples : Samples
        As the sensors gave them.
    frequency_hz, damping_ratio : (n_modes,) array [Hz], [-]
        Of all modes of the arm.
    shapes : (n_channels, n_modes) complex array
    lines_hz : tuple of (first, last) [Hz]
        Where each line stands at the beginning and at the end.
    above_db : tuple of float [dB]
        Power of each over that of chips alone, where it moved.
    chips : (n_samples, n_channels) array [m/s²]
        The same record without lines.
    """

    samples: Samples
    frequency_hz: Real
    damping_ratio: Real
    shapes: NDArray[np.complex128]
    lines_hz: tuple[tuple[float, float], ...]
    above_db: tuple[float, ...]
    chips: Real

    @property
    def asked(self) -> NDArray[np.bool_]:
        """Which modes are asked for, (n_modes,)."""
        cycles = self.damping_ratio * self.frequency_hz * self.samples.duration_s
        return np.asarray((self.frequency_hz < HIGHEST_HZ) & (cycles > LEAST_CYCLES))

    @property
    def moves(self) -> bool:
        """Whether the speed changes."""
        return any(first != last for first, last in self.lines_hz)


def scene(seed: int, speed: int, ramp: float = 0.0) -> Scene:
    """Draw and play the record of a seed.

    Parameters
    ----------
    seed : int
        Of pose, levels, chips and sensors; the pose alone is the same at all speeds.
    speed : int
        Which of the three.
    ramp : float
        By how much the speed grows over the record, of its mean.
    """
    model, layout = load_robot(ROBOT), load_layout(ROBOT)
    rng = np.random.default_rng([seed, 11])
    pose = model.pose(POSES[int(rng.integers(len(POSES)))])
    pose = pose + rng.uniform(-POSE_RAD, POSE_RAD, len(pose))
    sensors = tuple(dict.fromkeys(one.name.split('.')[0] for one in layout.channels))
    kept = sensors[::EVERY_SENSOR]
    channels = tuple(one for one in layout.channels if one.name.split('.')[0] in kept)
    rng = np.random.default_rng([seed, speed, round(1000 * ramp)])
    noise = int(rng.integers(2**31))  # chips and sensors of one speed tell nothing of another's

    def play(process: ProcessSettings, duration_s: float) -> tuple[Real, ArmSide]:
        own = CellSettings(sample_rate_hz=OVERSAMPLED * RATE_HZ, seed=noise, process=process)
        arm = ArmSide(model, channels, np.degrees(model.to_controller(pose)), own)
        n_rows = round(duration_s * OVERSAMPLED * RATE_HZ)
        still = np.zeros((n_rows, len(pose)))
        blocks = arm.take((np.tile(pose, (n_rows, 1)), still, still))
        rows = np.concatenate([block.acceleration for block in blocks]).astype(float)
        return resample_poly(rows, 1, OVERSAMPLED, axis=0, padtype='line'), arm

    rpm = SPEEDS_RPM[speed]
    chips = replace(CUT, seed=noise, background_n=CHIPS_N, speed_rpm=rpm)
    clean, arm = play(chips, DURATION_S)
    true = arm.model.damped_modes(pose, channels)
    hz = true.frequency_hz
    mode = int(rng.choice(np.flatnonzero((hz > NEAR_HZ[0]) & (hz < NEAR_HZ[1]))))
    order = NEAR * hz[mode] / (rpm / 60.0)
    unit = replace(
        chips,
        speed_rpm=rpm * (1.0 - 0.5 * ramp),
        speed_rate_rpm_s=ramp * rpm / DURATION_S,
        bearing_orders=(order, 0.0, 0.0),
    )
    alone = {
        'unbalance_g_mm': (replace(unit, background_n=0.0, unbalance_g_mm=100.0), 100.0),
        'bearing_n': (replace(unit, background_n=0.0, bearing_n=10.0), 10.0),
        'depth_mm': (replace(unit, background_n=0.0, depth_mm=0.1), 0.1),
    }
    chosen = {}
    for name, (process, value) in alone.items():
        trial = play(replace(process, speed_rate_rpm_s=0.0, speed_rpm=rpm), TRIAL_S)[0]
        lines = [line.order * rpm / 60.0 for line in _lines(process)]
        highest = max(_power(trial, at) / _power(clean, at) for at in lines)
        wanted = 10.0 ** (0.1 * rng.uniform(*LEVEL_DB))
        chosen[name] = value * math.sqrt(wanted / highest)
    whole = replace(unit, **chosen)
    rows, _ = play(whole, DURATION_S)
    first, last = rpm * (1.0 - 0.5 * ramp) / 60.0, rpm * (1.0 + 0.5 * ramp) / 60.0
    lines_hz = tuple((one.order * first, one.order * last) for one in _lines(whole))
    return Scene(
        Samples(rows, RATE_HZ, channels),
        hz,
        true.damping_ratio,
        true.channel_shapes,
        lines_hz,
        tuple(left_db(rows, clean, lines_hz)),
        clean,
    )


def _lines(process: ProcessSettings) -> tuple[ProcessLine, ...]:
    """Return the lines of a process that lie where the record can show them."""
    rate_hz = process.speed_rpm / 60.0
    found = SpindleProcess(process, 1.0 / RATE_HZ).lines
    return tuple(line for line in found if line.order * rate_hz < 0.4 * RATE_HZ)


def _power(rows: Real, hz: float, around_hz: float = AROUND_HZ) -> float:
    """Return the mean power within a distance of a frequency, summed over the channels."""
    taper = np.hanning(len(rows))
    own = rows - rows.mean(axis=0)
    power = np.abs(np.fft.rfft(own * taper[:, None], axis=0)) ** 2
    near = np.abs(np.fft.rfftfreq(len(rows), 1.0 / RATE_HZ) - hz) < around_hz
    return float(2.0 * power[near].sum() / (len(rows) * np.sum(taper**2)))


def left_db(rows: Real, clean: Real, lines_hz: Sequence[tuple[float, float]]) -> list[float]:
    """Return the power over that of chips alone where each line moved [dB]."""
    found = []
    for first, last in lines_hz:
        around = max(AROUND_HZ, 0.55 * abs(last - first))
        centre = 0.5 * (first + last)
        ratio = _power(rows, centre, around) / _power(clean, centre, around)
        found.append(10.0 * math.log10(ratio))
    return found
