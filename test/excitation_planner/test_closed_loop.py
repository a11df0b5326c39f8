"""The loop asks for what the worst mode needs, and stops."""

from dataclasses import replace
import math

import numpy as np
import pytest

from excitation_planner.closed_loop import next_step, plan_next, Targets
from excitation_planner.request import PlanRequest
from modal_core.mode import Mode, ModeSet
from structural_model import load_layout, load_robot

SHAPE = np.array([1.0 + 0j])


def modes(*entries):
    return ModeSet(
        tuple(
            Mode(f, z, SHAPE, frequency_std_hz=sf, damping_ratio_std=sz)
            for f, z, sf, sz in entries
        ),
        ('a.x',),
    )


GOOD = (10.0, 0.02, 0.01, 0.001)
POOR = (30.0, 0.02, 0.15, 0.001)


def test_stops_when_all_targets_are_met():
    step = next_step(PlanRequest(), modes(GOOD), Targets())
    assert step.done
    assert step.worst_frequency_hz == 10.0
    assert step.worst_shortfall == pytest.approx(0.5)


def test_raises_the_spectrum_at_the_worst_mode_and_lengthens_the_window():
    request = PlanRequest(seed=4, duration_s=20.0)
    step = next_step(request, modes(GOOD, POOR), Targets())
    assert not step.done
    assert step.worst_frequency_hz == 30.0
    asked = step.request
    assert asked.seed == 5
    assert asked.duration_s == 40.0
    gain = dict(zip(asked.shape_frequency_hz, asked.shape_gain, strict=True))
    at = {f: gain[min(gain, key=lambda k: abs(k - f))] for f in (10.0, 30.0, 50.0)}
    assert at[30.0] > 2.0 * at[10.0]
    assert at[30.0] > 2.0 * at[50.0]


def test_unknown_sigma_counts_as_worst():
    step = next_step(PlanRequest(), modes(GOOD, (30.0, 0.02, math.nan, math.nan)), Targets())
    assert step.worst_frequency_hz == 30.0
    assert not step.done
    assert np.all(np.isfinite(step.request.shape_gain))


def test_modes_outside_the_band_do_not_keep_the_loop_going():
    assert next_step(PlanRequest(), modes(GOOD, (80.0, 0.02, 5.0, 0.01)), Targets()).done


def test_ends_at_the_longest_window():
    request = PlanRequest(duration_s=60.0)
    targets = Targets(longest_s=60.0)
    assert next_step(request, modes(POOR), targets).done
    assert not next_step(replace(request, duration_s=30.0), modes(POOR), targets).done


def test_pulses_come_closer_together():
    request = PlanRequest(signal='random_pulses', interval_high_s=1.0)
    asked = next_step(request, modes(POOR), Targets()).request
    assert asked.interval_high_s < 1.0


def test_the_next_plan_predicts_a_smaller_sigma_for_the_worst_mode():
    """With real noise: the mode the loop was told about gains, under all limits."""
    robot, layout = load_robot('irb6660_205_190'), load_layout('irb6660_205_190')
    request = PlanRequest(duration_s=10.0, noise_density=0.3, enforce_tolerance=False)
    first = plan_next(robot, layout, request)
    weakest = max(
        (m for m in first.prediction.modes if m.frequency_hz > 5.5),
        key=lambda m: m.frequency_std_hz / m.frequency_hz,
    )
    found = modes(
        *(
            (m.frequency_hz, m.damping_ratio, m.frequency_std_hz, m.damping_ratio_std)
            for m in first.prediction.modes
        )
    )
    targets = Targets(frequency_std_ratio=1e-4, damping_ratio_std_ratio=1e-3, longest_s=10.0)
    asked = replace(next_step(request, found, targets).request, duration_s=10.0)
    second = plan_next(robot, layout, asked)
    same = min(second.prediction.modes, key=lambda m: abs(m.frequency_hz - weakest.frequency_hz))
    assert same.frequency_std_hz <= weakest.frequency_std_hz * 1.0001
