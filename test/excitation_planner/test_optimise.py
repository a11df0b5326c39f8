"""The search beats the paper's uniform intervals, with the same duration and no wider a range."""

import numpy as np
import pytest

from excitation_planner.optimise import natural_std, optimise, uniform_intervals, worst_mode
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from modal_core.errors import PlanError
from structural_model import load_layout, load_robot

ROBOT = 'irb6660_205_190'


@pytest.fixture(scope='module')
def robot():
    return load_robot(ROBOT)


@pytest.mark.slow
def test_optimised_pulses_know_the_worst_mode_better_than_uniform_intervals(robot):
    layout = load_layout(ROBOT)
    paper = uniform_intervals(
        PlanRequest(duration_s=10.0, noise_density=0.01, half_range=0.02, seed=2)
    )
    told = []
    found = optimise(robot, layout, paper, n_trials=12, progress=told.append)
    assert told == pytest.approx(np.arange(1, 13) / 12)
    before = plan_excitation(robot, layout, paper)
    after = plan_excitation(robot, layout, found.request)
    band = (paper.band_low_hz, paper.band_high_hz)
    worst = [natural_std(worst_mode(plan.prediction.modes, band)) for plan in (before, after)]
    assert worst == pytest.approx([found.baseline_worst_std, found.worst_std], rel=1e-9)
    assert worst[1] < 0.7 * worst[0]
    assert after.duration_s == before.duration_s
    assert np.all(after.position_range <= 1.05 * np.max(before.position_range))
    assert np.all(after.mode_frequency_sensitivity <= paper.frequency_tolerance)


def test_the_same_seed_finds_the_same_request(robot):
    layout = load_layout(ROBOT)
    request = PlanRequest(duration_s=4.0, noise_density=1.0, acceleration_rms=1.0)
    runs = [optimise(robot, layout, request, n_trials=5).request for _ in range(2)]
    assert runs[0] == runs[1]


def test_a_band_without_modes_is_refused(robot):
    layout = load_layout(ROBOT)
    request = PlanRequest(duration_s=4.0, band_low_hz=5.0, band_high_hz=6.0, acceleration_rms=0.3)
    with pytest.raises(PlanError, match='no mode to plan for'):
        optimise(robot, layout, request, n_trials=1)
