"""What a plan says will show is found when it is played."""

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from structural_model import load_robot
from structural_model.equations import random_poses

ROBOT = 'irb6660_205_190'
SEED = 7402


@pytest.mark.slow
def test_modes_that_random_pulses_forecast_are_found(tmp_path):
    model = load_robot(ROBOT)
    pose = random_poses(model.limits, 1, np.random.default_rng(SEED))[0]
    motion = ama.plan(
        ROBOT, start_position=pose.tolist(), seed=SEED, signal='random_pulses', duration_s=60
    )
    found = motion.emulate(tmp_path / 'pulses.mcap', {'seed': SEED}).identify(robot=ROBOT).modes
    frequency_hz = np.array([mode.frequency_hz for mode in found])
    forecast = [mode.frequency_hz for mode in motion.expected_modes if not mode.missed]
    assert 4 <= len(forecast) < len(motion.expected_modes)
    for expected_hz in forecast:
        assert np.min(np.abs(frequency_hz / expected_hz - 1.0)) < 0.02, f'seed {SEED}'
