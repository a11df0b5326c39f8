"""The emulated arm against its own motion: how many times faster than real time it is computed."""

from collections.abc import Iterator
import time

import numpy as np

from abb_emulator.mechanics.arm import Arm
from abb_emulator.mechanics.gear_settings import GearSettings
from benchmarks.table import Line
from structural_model import load_layout, load_robot

ROBOT, BLOCK, N_SAMPLES = 'irb6660_205_190', 64, 1024
PEAK_DEG_S2 = 80.0
REACH = {2048.0: 3.0, 4096.0: 1.5}
"""By sample rate [Hz]: a third, or two thirds, of one core."""
EVERYTHING = GearSettings(
    friction_nm=(50.0,) * 6,
    backlash_rad=(5e-5,) * 6,
    hardening_1_rad2=(1e6,) * 6,
    speed_stiffness_s_rad=(1.0,) * 6,
    slip_share=(0.3,) * 6,
    drift_change=(0.1,) * 6,
)


def rows() -> Iterator[Line]:
    """Yield the lines: every nonlinearity in every gear, or none."""
    for rate_hz, reach in REACH.items():
        for name, gears in (('linear gears', GearSettings()), ('all nonlinearities', EVERYTHING)):
            factors = real_time_factors(rate_hz, gears)
            best = float(factors.max())
            yield Line(
                f'24 flexible coordinates, 42 channels at {rate_hz:,.0f} Hz, {name}:'
                ' times real time, quickest block and median',
                f'{best:.1f}, {np.median(factors):.1f}',
                reach=f'≥ {reach}',
                met=best >= reach,
            )


def real_time_factors(rate_hz: float, gears: GearSettings) -> np.ndarray:
    """Return recorded over processor time of each block; others disturb the quickest least."""
    model, channels = load_robot(ROBOT), load_layout(ROBOT, 'sensors').channels
    pose = model.pose('P1')
    motion = shaking(pose, rate_hz)
    arm = Arm(model, channels, pose, 1.0 / rate_hz, gears)
    costs = []
    for first in range(0, N_SAMPLES, BLOCK):
        begin = time.process_time()
        arm.advance(*motion[:, first : first + BLOCK])
        costs.append(time.process_time() - begin)
    return BLOCK / rate_hz / np.array(costs)


def shaking(pose: np.ndarray, rate_hz: float) -> np.ndarray:
    """Return one sine of 8 to 30 Hz per axis: position, speed, acceleration; seed 3."""
    rng = np.random.default_rng(3)
    omega, phase = 2.0 * np.pi * rng.uniform(8.0, 30.0, 6), rng.uniform(0.0, 6.0, 6)
    size = np.radians(PEAK_DEG_S2) / omega**2
    angle = omega * np.arange(1, N_SAMPLES + 1)[:, None] / rate_hz + phase
    swing = size * (np.sin(angle) - np.sin(phase))
    return np.array([pose + swing, size * omega * np.cos(angle), -size * omega**2 * np.sin(angle)])
